"""Files that are not there or cannot be read: E3."""

from __future__ import annotations

from rulesheets.catalogue.entry import Entry

FILES: dict[str, Entry] = {
    "E301": Entry(
        "there is no such file",
        "The path does not lead to a file.",
        "Paths are relative to the folder that you are in.",
    ),
    "E302": Entry(
        "this is a folder, not a file",
        "A sheet is one text file, or a folder that holds a model.tk.",
        "Name a file in the folder.",
    ),
    "E303": Entry(
        "this is not a text file",
        "A rule sheet is UTF-8 text; the file has bytes that are not.",
        "Save the sheet as UTF-8 text.",
    ),
    "E304": Entry(
        "this file cannot be read",
        "The system refuses to read it.",
        "Check its permissions.",
    ),
    "E305": Entry(
        "this file is too large for a rule sheet",
        "A rule sheet has at most 64 MB.",
        "Split it into files of functions.",
    ),
    "E306": Entry(
        "a used file is missing",
        "The path of `use` leads to no file.",
        "Paths are relative to the file that names them.",
    ),
    "E307": Entry(
        "files use each other in a circle",
        "A file leads back to itself by `use`.",
        "Move what both need into a file of its own.",
    ),
    "E308": Entry(
        "a used file has rules of its own",
        "Only functions are taken from a used file, and nothing is silently left out.",
        "Move the functions into a file of their own.",
    ),
    "E309": Entry(
        "there is no such sheet or model",
        "A bare name is that of a shipped model.",
        "Take the suggestion, or give the path of a sheet.",
    ),
    "E310": Entry(
        "there is no such variable sheet",
        "The path leads to no file, and no file of that name stands beside the rule sheet.",
        "Take the suggestion, or give the path of the variable sheet.",
    ),
    "E311": Entry(
        "a file lies outside the folder that sheets are confined to",
        "With --within (within= in Python) only files of one folder may be read, links resolved.",
        "Copy the file into the folder.",
    ),
    "E312": Entry(
        "this file is no rule sheet",
        "Its name does not end in .tk, and it cannot be read as one. Nothing of its text is shown.",
        "Give the path of a rule sheet. If it is meant as one, let its name end in .tk to see what is wrong.",
    ),
    "E313": Entry(
        "a Python file is not allowed to run",
        "A sheet names it by `use python`, and nobody has allowed it: it can do anything that you can.",
        "Read it, and if you trust it, give --allow-python (allow_python=True in Python).",
    ),
    "E314": Entry(
        "a Python file failed",
        "It raised an error while it ran, or registered a function that does not fit.",
        "Run it with Python by itself, and mend it.",
    ),
    "E315": Entry(
        "a function of your own failed",
        "It raised an error other than ValueError and ArithmeticError, which say that there is no value.",
        "Mend the function, or let it raise ValueError where it has no value.",
    ),
}
