"""Names, calls and figures that do not fit together: E2."""

from __future__ import annotations

from rulesheets.catalogue.entry import Entry

NAMES: dict[str, Entry] = {
    "E201": Entry(
        "there is no such function",
        "The name is misspelt, its file is not used, or a product lacks its `*`.",
        "Take the suggestion, add `use`, or write a*(b + c).",
    ),
    "E202": Entry(
        "this function is not there yet",
        "sum, prod and count work on lists, which are planned.",
        "Write the terms out.",
    ),
    "E203": Entry(
        "the number of arguments is wrong",
        "The call passes more or fewer arguments than the function takes.",
        "Call it as its head says.",
    ),
    "E204": Entry(
        "the number of results is wrong",
        "The call takes more or fewer results than the function gives; in an expression it is one.",
        "Call it as its head says, on a line of its own where it has several results.",
    ),
    "E205": Entry(
        "the caller lacks a parameter",
        "Parameters are shared by name, and the calling sheet or function has no such variable.",
        "Name the variable in the calling sheet, or add it to the parameters of the calling function.",
    ),
    "E206": Entry(
        "a function is defined twice",
        "Two functions have the same name; capitals do not count.",
        "Rename one of them.",
    ),
    "E207": Entry(
        "a built-in function is defined anew",
        "A function of the sheet has the name of a built-in one.",
        "Give it a name of its own.",
    ),
    "E208": Entry(
        "a function leads back to itself",
        "A rule function stands for its rules, so no chain of calls may come round.",
        "Break the circle; a loop of equations needs no recursion.",
    ),
    "E209": Entry(
        "a name has two roles in a function",
        "The same name is argument, result or parameter more than once.",
        "Keep one of the roles.",
    ),
    "E210": Entry(
        "a function is used as a variable",
        "The name of a function stands without its arguments, or is given to a variable.",
        "Add the arguments, or rename the variable.",
    ),
    "E211": Entry(
        "a symbol in arithmetic",
        "A symbol such as 'open is no number.",
        "Compare it by = or <>, or leave out the apostrophe.",
    ),
    "E212": Entry(
        "a symbol compared by order",
        "Symbols are equal or different; they have no order.",
        "Use = or <>.",
    ),
    "E213": Entry(
        "the sides of a rule differ in length",
        "A rule of tuples equates them one by one.",
        "Write as many expressions on either side.",
    ),
    "E214": Entry(
        "given() asks for an unknown variable",
        "No rule and no row has the name.",
        "Take the suggestion.",
    ),
    "E215": Entry(
        "a variable has two rows",
        "The variables section names it twice.",
        "Keep one row.",
    ),
    "E216": Entry(
        "calls multiply beyond bounds",
        "Functions that call functions several times each grow the model exponentially.",
        "Call fewer functions in functions.",
    ),
    "E217": Entry(
        "an expression nests too deep",
        "What works on expressions takes one level after the other, and they are limited.",
        "Split it over several rules.",
    ),
    "E218": Entry(
        "the end of a range names an unknown variable",
        "No rule and no other row has the name.",
        "Take the suggestion, or write a number.",
    ),
    "E219": Entry(
        "a name is read as pi",
        "The number is written pi, in small letters; Pi and PI can be no variables.",
        "Write pi.",
    ),
    "E230": Entry(
        "a figure names an unknown variable",
        "The coordinates of a figure are those of variables of the sheet, locals by their full names.",
        "Take the suggestion; a local is named as in position.yB.",
    ),
    "E231": Entry(
        "a figure names an unknown point",
        "Links, joints and vectors stand between points of the same figure.",
        "Take the suggestion, or add the point.",
    ),
    "E232": Entry(
        "a point or a figure has its name twice",
        "Points are told apart by their names, and so are the figures of a sheet.",
        "Rename one of them.",
    ),
    "E233": Entry(
        "a coordinate is no number",
        "A coordinate or a direction of a figure is a symbol, or a variable that holds one.",
        "Name a variable that holds a number.",
    ),
}
