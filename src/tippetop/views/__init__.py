"""Pages that a browser opens without a network: a run, a sweep, the playground.

- `run_page.page`, `sweep_page.page_of_sweep` and `playground.playground` return the text of a page.
- `pages.page` joins style, data and one script made of the modules in `page/`.
- `phase_formulas` writes the formulas of this package as JavaScript.

Rows of a run become `samples`, of which `spacing` keeps those that the picture needs.
"""
