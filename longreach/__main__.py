"""`python -m longreach` is `longreach`."""

import sys

from daemon.cli.main import main

sys.exit(main())
