"""`python -m ddgi`: the same as the `ddgi` command."""

import sys

from ddgi.cli import main

sys.exit(main())
