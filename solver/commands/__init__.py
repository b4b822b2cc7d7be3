"""The commands of ``backsolve``, one a file: ``add_arguments(parser)`` and ``run(arguments) -> exit code``.

What several of them need stands in ``inputs``, ``over``, ``rows`` and ``progress``. Neither sympy nor
matplotlib is imported before a command asks for it.
"""

UNSOLVED = 1
WRONG = 2
"""Exit code where the sheet or the command is wrong."""
