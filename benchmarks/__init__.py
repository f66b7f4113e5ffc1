"""How fast the twins are, each figure as a ratio to a peer measured in the same run.

pip install --editable '.[dev]'
python -m benchmarks.report     # five runs, then writes docs/performance.md
python -m pytest benchmarks     # one run, to look at
"""
