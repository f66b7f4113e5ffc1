"""python -m simulators: the command canopen-twin."""

import sys

from simulators.cli import main

sys.exit(main())
