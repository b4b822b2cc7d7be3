"""Lines that cannot be read: E1."""

from __future__ import annotations

from rulesheets.catalogue.entry import Entry

SYNTAX: dict[str, Entry] = {
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
        "A rule says that two sides are equal; a = b = c is two rules, and so is a = b < c.",
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
    "E128": Entry(
        "a line of the units section that defines no unit",
        "A line names a unit and says what it is in terms of others: smoot = 1.7018 m.",
        "Write name = factor unit, or a name alone for a unit of a kind of its own.",
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
}
