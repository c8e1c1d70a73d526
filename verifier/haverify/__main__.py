"""`python -m haverify`."""

import sys

from haverify.cli import main

sys.exit(main())
