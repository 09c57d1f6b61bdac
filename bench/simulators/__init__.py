"""Run the cases of `tippetop benchmark export` in contact engines: `python -m bench.simulators`."""
