"""The commands of ``backsolve``: each by its name, with the module that it is in and what it does.

Neither sympy nor matplotlib is imported before a command asks for it.
"""

UNSOLVED = 1
WRONG = 2
"""Exit code where the sheet or the command is wrong."""

COMMANDS = {
    "solve": ("solve", "solve a sheet and print its variable sheet"),
    "sweep": ("sweep", "solve a sheet for many values of an input"),
    "draw": ("draw", "draw the figures of a sheet to scale"),
    "chart": ("chart", "measure methods on a sheet: speed against accuracy"),
    "path": ("explaining", "show the order in which the rules are solved"),
    "why": ("explaining", "show the chain of rules behind one number"),
    "check": ("reading", "read a sheet and say what is wrong with it"),
    "format": ("reading", "print a sheet in its canonical form"),
    "open": ("serving", "open a sheet as a page in the browser"),
    "export": ("serving", "write a sheet as one file with sliders"),
    "watch": ("solve", "solve a sheet whenever it is saved"),
    "tutor": ("about", "learn the first steps, in five minutes"),
    "lsp": ("serving", "serve an editor: the language server"),
    "completion": ("about", "print what a shell completes commands by"),
    "models": ("about", "list the sheets that come with Backsolve"),
    "codes": ("about", "say what the code of a message means"),
    "cache": ("about", "show what is kept between runs, or clear it"),
}
