"""``python -m solver`` is the ``backsolve`` command."""

from __future__ import annotations

import sys

from solver.cli import main

sys.exit(main())
