"""python -m canopen_twins: the command canopen-twin."""

import sys

from canopen_twins.cli import main

sys.exit(main())
