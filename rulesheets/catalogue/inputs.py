"""Values, variable sheets and options that set them: E401 to E425."""

from __future__ import annotations

from rulesheets.catalogue.entry import Entry

INPUTS: dict[str, Entry] = {
    "E401": Entry(
        "an input names a variable",
        "An input is evaluated once, before anything is solved.",
        "Write a rule, or a symbol with its apostrophe.",
    ),
    "E402": Entry(
        "an input is not finite",
        "Its expression has no value, or none that is finite.",
        "Give a finite number, or leave it out.",
    ),
    "E403": Entry(
        "an input lies outside its range",
        "The variables section states where the variable may lie.",
        "Change the value or the range.",
    ),
    "E404": Entry(
        "a guess is no number",
        "A symbol cannot be approached step by step.",
        "Give it as an input.",
    ),
    "E405": Entry(
        "a tolerance that cannot be one",
        "It is negative, a symbol, or stands after a symbol.",
        "Write it as in = 3 ± 0.01, or = 3 ± 1%.",
    ),
    "E406": Entry(
        "this is not a value",
        "A value is a number, an expression of numbers, or a symbol.",
        "Write it as 3, 2*3 or 'open.",
    ),
    "E407": Entry(
        "there is no such variable",
        "The model has no variable of this name.",
        "Take the suggestion; locals of a call have dotted names.",
    ),
    "E410": Entry(
        "a variable sheet needs the column Name",
        "The heading does not name it.",
        "Begin with St,Input,Name,Output,Unit,Comment.",
    ),
    "E411": Entry(
        "a variable sheet has no such column",
        "The heading names a column that means nothing.",
        "Take the suggestion, or remove it.",
    ),
    "E412": Entry(
        "there is no such status",
        "The column St is blank, I, O, G or C.",
        "Clear the cell, or write G for a guess.",
    ),
    "E413": Entry(
        "an input belongs to no variable",
        "The cell Name is blank.",
        "Fill it in.",
    ),
    "E414": Entry(
        "a variable has two rows",
        "The variable sheet names it twice.",
        "Keep one row.",
    ),
    "E415": Entry(
        "a row has too many cells",
        "A cell holds a comma without quotes.",
        "Put the cell in double quotes.",
    ),
    "E416": Entry(
        "a file cannot be written",
        "The place does not exist or may not be written to.",
        "Choose another place.",
    ),
    "E418": Entry(
        "an output would overwrite an input",
        "The file to write is one that is read: the sheet, a file that it uses, or a file of inputs.",
        "Write to another file.",
    ),
    "E420": Entry(
        "an option needs a name and a value",
        "--set and --guess take NAME=VALUE.",
        "Write --set x=3.",
    ),
    "E421": Entry(
        "a variable is given twice",
        "Two options say what one variable is.",
        "Keep one of them.",
    ),
    "E423": Entry(
        "a guess that cannot be one",
        "The variable is an input, or the guess is a symbol.",
        "Take the input back by --clear, or give the symbol by --set.",
    ),
    "E424": Entry(
        "a range that cannot be swept",
        "--over takes NAME=A,B,… or NAME=START:STOP:STEP, with a step that leads from start to stop.",
        "Write --over x=0:1:0.1, or --over x=1,2,5.",
    ),
    "E425": Entry(
        "a derivative by what is no number",
        "Sensitivities and tolerances are those of inputs that have a number.",
        "Name an input, or give the variable a number.",
    ),
}
