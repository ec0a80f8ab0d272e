"""A problem the whole way of an annealer: encode, reduce, anneal what is left, decode, score."""

import csv

from scenes import call

KINDS = {"restore": "picture", "segment": "labels", "flow": "flow", "register": "flow",
         "detect": "boxes"}
# At most so many variables are left to the annealer: a reduction goes no further than that.
TARGET = 500
# Options of the commands in one go that are not those of their problems.
APART = ("-o", "--truth", "--color", "--warped")


def split(words):
    """(operands and options of the problem, {option: value} of APART)."""
    kept, apart, words = [], {}, list(map(str, words))
    while words:
        word = words.pop(0)
        if word in APART:
            apart[word] = words.pop(0)
        else:
            kept.append(word)
    return kept, apart


def kept_boxes(boxes, kept, path):
    """The lines of the boxes that decode's list keeps, as `qstereo score` reads them."""
    with open(boxes) as file, open(kept) as choice:
        rows = [row for row, one in zip(csv.DictReader(file), csv.DictReader(choice), strict=True)
                if one["keep"] == "1"]
    with open(path, "w") as file:
        writer = csv.DictWriter(file, rows[0])
        writer.writeheader()
        writer.writerows(rows)


def whole_way(qstereo, bridge, command, folder):
    """What a command of one go gives by this way: a dict of figures."""
    (problem, *words), apart = split(command)
    whole, core, samples = (folder / name for name in ("p.qcf", "core.qcf", "s.qsf"))
    found = folder / ("found-" + str(apart["-o"]).rsplit("/", 1)[-1])
    encoded = call(qstereo, "encode", "--problem", problem, *words, "-o", whole)
    reduced = call(qstereo, "reduce", whole, "-o", core, "--target", TARGET)
    answer = []
    if reduced["variables_after"]:
        call(bridge, "solve", core, "-o", samples, "--solver", "anneal", "--num-reads", 20,
             "--seed", 1, "--alone")
        answer = [samples]
    decoded = call(qstereo, "decode", core, *answer, "-o", found)
    scores = {}
    if "--truth" in apart:
        if problem == "detect":
            kept_boxes(words[0], found, folder / "boxes.csv")
            found = folder / "boxes.csv"
        scores = call(qstereo, "score", found, apart["--truth"], "--as", KINDS[problem])
    return {"problem": problem, "encoding": encoded["encoding"],
            "before": reduced["variables_before"], "after": reduced["variables_after"],
            "energy": decoded["energy"], "lower_bound": reduced["lower_bound"], "scores": scores}
