"""The catalogue of diagnoses: every code with its title, its usual cause and its cure.

E1 syntax, E2 names and calls, E3 files, E4 variable sheets and command input, S5 outcomes of a solve.
A code never changes its meaning; one that is not used any more is not given away again.
"""

from __future__ import annotations

from rulesheets.record import dataclass


@dataclass(frozen=True, slots=True)
class Entry:
    title: str
    cause: str
    fix: str


CATALOGUE: dict[str, Entry] = {
    "E101": Entry(
        "this cannot be read here",
        "The line begins like a rule, but something in it does not belong there.",
        "Look at the marked place; the help line says what could stand there.",
    ),
    "E102": Entry(
        "a parenthesis is never closed",
        "An opening parenthesis has no partner before the end of the rule.",
        "Add the closing parenthesis.",
    ),
    "E103": Entry(
        "a closing parenthesis has no partner",
        "More parentheses are closed than were opened.",
        "Remove it, or open one before.",
    ),
    "E104": Entry(
        "an operand is missing",
        "An operator, a comma or an equals sign has nothing on one of its sides.",
        "Write what belongs there, or remove the operator.",
    ),
    "E105": Entry(
        "a product needs a `*`",
        "Two factors stand side by side; there is no implicit product.",
        "Write 2*x for 2x, a*(b + c) for a(b + c).",
    ),
    "E106": Entry(
        "a rule has one equals sign",
        "A rule says that two sides are equal; a = b = c is two rules.",
        "Write a = b and b = c on two lines.",
    ),
    "E107": Entry(
        "a number cannot be read",
        "A number has two points, an exponent without digits, a comma, or is out of range.",
        "Write numbers as 3, 0.5, .5 or 1e-3.",
    ),
    "E108": Entry(
        "a character has no meaning in a rule sheet",
        "It looks like a sign of the language (− × ÷ “ ” ²) or comes from another language.",
        "Write the plain sign that the help line names.",
    ),
    "E109": Entry(
        "`then` is missing",
        "A condition is followed by `then` and the rule that holds if it is true.",
        "Write if condition then rule.",
    ),
    "E110": Entry(
        "this is not a condition",
        "A condition compares (a < b, a = 'open); a bare expression is neither true nor false.",
        "Compare it with something, as in x + 1 > 0.",
    ),
    "E111": Entry(
        "a comparison is not a rule",
        "A rule is an equation; an inequality cannot be solved for a value.",
        "Give the range in the variables section (x < 3), or use it as a condition after `if`.",
    ),
    "E112": Entry(
        "`else` has no `if`",
        "An `else` follows the rule after `then`, of an `if` of the same line.",
        "Write if condition then rule else rule.",
    ),
    "E113": Entry(
        "this is no rule: it has no equals sign",
        "A rule is an equation (a = b), a conditional (if … then …) or a call (call f(a; x)).",
        "Write an equation.",
    ),
    "E114": Entry(
        "no variable stands in this rule",
        "A rule between numbers says nothing about any variable.",
        "Write name = number.",
    ),
    "E115": Entry(
        "`=` is the only sign of equality",
        "Rules are undirected: nothing is assigned. `:=` and `==` come from other languages.",
        "Write `=`.",
    ),
    "E116": Entry(
        "unknown section",
        "A lone word is taken for the head of a section; there are variables, rules, function and use.",
        "Write one of these, or complete the rule.",
    ),
    "E117": Entry(
        "unknown keyword",
        "The first word of the line looks like a misspelt keyword.",
        "Write the keyword that the help line names.",
    ),
    "E118": Entry(
        "a section head is not complete",
        'A head such as function f(a; x), parameters a, b or use "file.tk" lacks a part.',
        "Write it as the help line shows.",
    ),
    "E119": Entry(
        "this section cannot stand here",
        "`parameters` belong between the head of a function and its rules.",
        "Move the line.",
    ),
    "E120": Entry(
        "this is not a row of the variables section",
        "A row is a name with a value, a guess, a unit, a range and a comment, all but the name optional.",
        'Write it as name = value [unit] " comment, or put rules under `rules`.',
    ),
    "E121": Entry(
        "a range is wrong",
        "The ends of a range are numbers, the lower one first, each given once.",
        "Write it as in [0, 5], or as > 0, < 5.",
    ),
    "E122": Entry(
        "a unit is never closed",
        "A unit stands in brackets on one line.",
        "Add the closing bracket: [rad/s].",
    ),
    "E123": Entry(
        "a file name is never closed",
        "The file names of `use` stand in quotes.",
        "Add the closing quote.",
    ),
    "E124": Entry(
        "nested too deeply",
        "More parentheses, signs, powers or conditions stand in each other than can be followed.",
        "Give parts of the rule names of their own.",
    ),
    "E125": Entry(
        "this line is too long",
        "A rule has more characters than can be read in reasonable time.",
        "Split the rule.",
    ),
    "E126": Entry(
        "this sheet has no rule",
        "A rule sheet states at least one rule or function.",
        "Write a rule, such as V = I*R.",
    ),
    "E127": Entry(
        "a keyword cannot be a name",
        "if, then, else, call, and, or, not are words of the language in any case.",
        "Give the variable another name.",
    ),
    "E130": Entry(
        "this is not a line of a figure",
        "A figure holds points, links, joints and vectors, each a word with parentheses.",
        "Write it as point A = (x, y), line (O, A) or slider (B, 0), or put rules under `rules`.",
    ),
    "E131": Entry(
        "a line of a figure is not complete",
        "A mark lacks its name, or has more or fewer parts than its kind takes, or others.",
        "Write it as the help line shows.",
    ),
    "E190": Entry(
        "this is not there yet",
        "Lists, list functions and procedures are planned.",
        "See the help line for what can be written today.",
    ),
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
    "E301": Entry(
        "there is no such file",
        "The path does not lead to a file.",
        "Paths are relative to the folder that you are in.",
    ),
    "E302": Entry(
        "this is a folder, not a rule sheet",
        "A rule sheet is one text file.",
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
    "E417": Entry(
        "the unit is another",
        "Units are kept and shown, but not converted yet.",
        "Give the value in the unit of the sheet.",
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
    "E422": Entry(
        "a value is given in another unit",
        "Units are kept and shown, but not converted yet.",
        "Give the value in the variable's own unit, or leave the unit out.",
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
    "E430": Entry(
        "there is no figure",
        "A sheet says by `figure` sections what is drawn of it, and this one has none.",
        "Add a figure to the sheet.",
    ),
    "E431": Entry(
        "there is no such figure",
        "No figure of the sheet has the name.",
        "Take the suggestion.",
    ),
    "E432": Entry(
        "drawing needs matplotlib",
        "Pictures are an extra, which is not installed.",
        "Install it by `pip install 'backsolve[plot]'`",
    ),
    "E433": Entry(
        "the ending of the file says no kind of picture",
        "Pictures end in .png, .svg or .pdf, films in .gif, charts in .png, .svg or .csv.",
        "Choose one of these endings.",
    ),
    "E434": Entry(
        "a resolution out of range",
        "--dpi is the number of dots an inch.",
        "Give 10 to 2400, or leave it out.",
    ),
    "E440": Entry(
        "a file of rows cannot be read",
        "--rows takes a CSV file whose first line names inputs, or a Parquet file, one row a solve.",
        "Mend the place that the message names, or choose columns with --columns.",
    ),
    "E441": Entry(
        "an optional package is not installed",
        "Parquet files, pictures and clusters need packages that the plain installation leaves out.",
        "Install the extra that the help line names.",
    ),
    "E442": Entry(
        "a table is not written under this ending",
        "The ending of the file says in which form a table is written.",
        "Choose one of the endings that the help line names.",
    ),
    "E443": Entry(
        "a sweep that is not determined",
        "The rows of a sweep come either from ranges (--over) or from a file (--rows), and from one of them.",
        "Give one of the two.",
    ),
    "E444": Entry(
        "a cluster that cannot be used",
        "The scheduler does not answer, or its workers cannot do the work.",
        "See that the scheduler runs at this address, and its workers with the same Backsolve.",
    ),
    "E445": Entry(
        "a sweep that cannot be drawn",
        "A picture shows wanted numbers over one or two swept inputs, up to a number of rows.",
        "Sweep fewer inputs, or take a larger step.",
    ),
    "E446": Entry(
        "a worker process ended",
        "A process that solved rows was ended from outside, again and again: most often for want of memory.",
        "Free some memory, or give --jobs 1.",
    ),
    "E447": Entry(
        "a curve that cannot be followed",
        "--follow goes along a curve: over one range, in this process, without pictures.",
        "Give one --over and leave the other options out.",
    ),
    "E449": Entry(
        "proof needs python-flint",
        "Rigorous enclosures are an extra, which is not installed.",
        "Install it by `pip install 'backsolve[proof]'`",
    ),
}
