"""What a solve can come to that needs a word, S5: the other codes are in ``rulesheets.catalogue``."""

from __future__ import annotations

from rulesheets.catalogue.entry import Entry

OUTCOMES: dict[str, Entry] = {
    "S510": Entry(
        "the inputs do not determine everything that is wanted",
        "There are more unknowns than rules that tell of them.",
        "Give one of the inputs that the help line names, or ask for less with --want.",
    ),
    "S511": Entry(
        "rules say the same thing twice",
        "There are as many rules as unknowns, but one of them follows from the others.",
        "Give one of the variables that the help line names, or add a rule that says something new.",
    ),
    "S520": Entry(
        "rules contradict each other, or the inputs",
        "No values can satisfy all of the rules shown; leaving out any one of them would help.",
        "Take back one of the inputs named: the notes say what the others make of it.",
    ),
    "S521": Entry(
        "a given number is fixed otherwise, whatever an unknown is",
        "The rules determine it from other inputs; the variable that was freed has no part in it.",
        "Leave it out, or free an input that it depends on.",
    ),
    "S530": Entry(
        "no value satisfies a rule",
        "An operation would need what it cannot have: the root of a negative number, a cosine beyond 1.",
        "Move an input to where the note says that there is a solution.",
    ),
    "S531": Entry(
        "the only values lie outside a range",
        "The sheet bounds the variable, and the rules lead beyond.",
        "Move an input, or widen the range.",
    ),
    "S532": Entry(
        "no values satisfy several rules together",
        "It is proven: the whole of the ranges was excluded.",
        "Move an input to where the note says that there is a solution, or widen a range.",
    ),
    "S533": Entry(
        "no case of the conditional rules fits",
        "Each case leads to values that contradict the condition it was assumed under.",
        "Look at the conditions, or move an input.",
    ),
    "S534": Entry(
        "a rule computes with a symbol",
        "A symbol equals itself alone: there is no arithmetic with it.",
        "Give a number for the variable, or clear it to have it solved.",
    ),
    "S535": Entry(
        "an answer does not meet a requirement",
        "A rule that is an inequality is asked of answers; those that break it are not listed.",
        "Move an input to where the note says that there is a solution, or change the requirement.",
    ),
    "S540": Entry(
        "a variable drops out of its rule",
        "At these values the rule holds whatever the variable is, as where it is multiplied by 0.",
        "Give the variable, or change the position.",
    ),
    "S541": Entry(
        "two answers coincide",
        "The answer is a double root (a dead centre, two circles that touch), which rounding parts or loses.",
        "Move an input a little away, unless this is the point that is looked for.",
    ),
    "S542": Entry(
        "rules leave a direction free at these values",
        "Elsewhere they would determine the unknowns; here one of them follows from the others.",
        "Give one of the variables that the help line names, or change the position.",
    ),
    "S543": Entry(
        "nothing is determined at a double root",
        "What follows from a double root can have any value there, or none.",
        "Give the variables of the double root first, or move away from it.",
    ),
    "S544": Entry(
        "a value rests on rounding alone",
        "A rule divides by a difference that is no more than the last places of the given numbers.",
        "Give the difference itself, or the variable, or more digits.",
    ),
    "S545": Entry(
        "a rule is undefined here (0/0)",
        "A quotient is 0/0 at these values, as the logarithmic mean of two equal differences is.",
        "Take the limit with --limits where there is one, or move an input a little.",
    ),
    "S550": Entry(
        "no answer was found",
        "The search ended without an answer, and nothing shows that there is none.",
        "Give a guess for one of the unknowns, or a range.",
    ),
    "S551": Entry(
        "a value is beyond the floating point numbers",
        "It is too large, too small, or too near to another number to be told from it.",
        "Scale the rule, or choose other units.",
    ),
    "S552": Entry(
        "the search did not cover every case",
        "Conditions wait for unknowns in more ways than were tried, and none of these led to an answer.",
        "Give a guess or a range for one of the unknowns.",
    ),
    "S553": Entry(
        "the time was up",
        "The limit in time (--timeout, or timeout= in Python) ended the search before it was done.",
        "Give more time, a guess or a range for one of the unknowns, or ask for less with --want.",
    ),
    "S590": Entry(
        "there are too many to list",
        "Answers or cases multiply from step to step.",
        "Give ranges to the unknowns, or more inputs.",
    ),
    "S591": Entry(
        "a variable has no value here",
        "Its rule asks for what is not there, but nothing that is wanted needs it.",
        "Nothing need be done; the variable stays blank.",
    ),
    "S592": Entry(
        "a derivative does not exist",
        "The rules change there, the output is a symbol or blank, or the answer is singular.",
        "Move an input a little and ask again.",
    ),
    "S593": Entry(
        "there are more answers than are listed",
        "The unknown repeats itself, as an angle does that counts whole turns.",
        "Give the unknown a range, or a guess to list those nearest to it first.",
    ),
    "S594": Entry(
        "nothing shows that these are all answers",
        "The search found these and no others, which is no proof.",
        "Give the unknowns finite ranges, which can be searched whole.",
    ),
    "S595": Entry(
        "a rule was taken by its limit",
        "It is 0/0 at the answer, and has the same limit from all sides.",
        "Nothing need be done: this is what --limits asks for.",
    ),
    "S596": Entry(
        "there is a curve of answers beside the isolated ones",
        "Where a factor is 0, the rules hold whatever the variables named are.",
        "Nothing need be done; a range that leaves the factor out leaves the curve out, too.",
    ),
}
