"""Classes that `help` explains by their docstring alone."""


class Described(type):
    """A class of records: its docstring lists the fields, so that `help` shows that and no more."""

    def __dir__(cls) -> list[str]:
        """Return what `help` adds to the docstring: nothing."""
        return []
