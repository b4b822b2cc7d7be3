"""The commands of ``backsolve``, one a file: ``add_arguments(parser)`` and ``run(arguments) -> exit code``.

Their modules import nothing heavy at the top, so that ``--help`` answers at once.
"""
