"""Codes, pictures, tables, sweeps and proofs that cannot be had: from E426."""

from __future__ import annotations

from rulesheets.catalogue.entry import Entry

REQUESTS: dict[str, Entry] = {
    "E426": Entry(
        "there is no such code",
        "Codes are a letter and three digits, printed in brackets before a message.",
        "Write it as in backsolve codes E105.",
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
    "E448": Entry(
        "a sweep that cannot go on",
        "--resume continues the file of a sweep that was cut off: the same rows, columns and order.",
        "Give the options that the file was written with, or leave --resume out.",
    ),
    "E449": Entry(
        "proof needs python-flint",
        "Rigorous enclosures are an extra, which is not installed.",
        "Install it by `pip install 'backsolve[proof]'`",
    ),
}
