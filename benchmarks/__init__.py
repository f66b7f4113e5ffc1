"""How fast the twins are, each figure as a ratio to a peer measured in the same run.

With the package installed (`pip install --editable '.[dev]'`), `python -m benchmarks.report`
runs them five times and writes docs/performance.md; `python -m pytest benchmarks` runs them once.
"""
