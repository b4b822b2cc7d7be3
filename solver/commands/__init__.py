"""The commands of ``backsolve``: each by its name, with its module in the solver, and what it does.

Neither sympy nor matplotlib is imported before a command asks for it.
"""

UNSOLVED = 1
WRONG = 2
"""Exit code where the sheet or the command is wrong."""

COMMANDS = {
    "solve": ("commands.solve", "solve a sheet and print its variable sheet"),
    "sweep": ("commands.sweep", "solve a sheet for many values of an input"),
    "draw": ("commands.draw", "draw the figures of a sheet to scale"),
    "chart": ("commands.chart", "measure methods on a sheet: speed against accuracy"),
    "path": ("commands.solve", "show the order in which the rules are solved"),
    "why": ("commands.solve", "show the chain of rules behind one number"),
    "check": ("commands.solve", "read a sheet and say what is wrong with it"),
    "format": ("commands.solve", "print a sheet in its canonical form"),
    "open": ("page.serving", "open a sheet as a page in the browser"),
    "export": ("page.serving", "write a sheet as one file with sliders"),
    "watch": ("commands.solve", "solve a sheet whenever it is saved"),
    "tutor": ("commands.about", "learn the first steps, in five minutes"),
    "lsp": ("page.serving", "serve an editor: the language server"),
    "completion": ("commands.about", "print what a shell completes commands by"),
    "models": ("commands.about", "list the sheets that come with Backsolve"),
    "codes": ("commands.about", "say what the code of a message means"),
    "cache": ("commands.about", "show what is kept between runs, or clear it"),
}
