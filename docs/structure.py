#!/usr/bin/env python3
"""Counts what says how coupled the solver is: the table at the end of docs/architecture.md.

    docs/structure.py            prints the table
    docs/structure.py --write    puts it there
"""

import pathlib
import re
import sys

ROOT = pathlib.Path(__file__).resolve().parent.parent
PAGE = ROOT / "docs/architecture.md"
# Where what is public is named, if it is.
OUTSIDE = ("analysis", "models", "src", "bindings/python/src", "tests", "solver/tests", "examples", "benches", "testing")
HEAD = "| figure | now |\n|---|---:|\n"


def sources(folder):
    """Texts of all Rust files below a folder, by path."""
    return {path: path.read_text() for path in sorted((ROOT / folder).rglob("*.rs"))}


def block(text, start):
    """The braces that open behind the first match of `start`, and what is between them."""
    begin = text.index("{", re.search(start, text).start())
    depth = 0
    for place in range(begin, len(text)):
        depth += {"{": 1, "}": -1}.get(text[place], 0)
        if depth == 0:
            return text[begin : place + 1]
    raise ValueError(start)


def functions(text):
    return len(re.findall(r"^    (?:pub(?:\([a-z ]+\))? )?(?:const )?fn ", text, re.M))


def rows():
    solver, chains = sources("solver/src"), sources("chains/src")
    system = (ROOT / "solver/src/system/mod.rs").read_text()
    fields = re.findall(r"^    (?:pub(?:\([a-z ]+\))? )?\w+:", block(system, r"pub struct System<"), re.M)
    methods = [text for text in solver.values() if re.search(r"^impl<const D: usize> System<D>", text, re.M)]
    parts = [
        block(text[match.start() :], r"impl")
        for text in methods
        for match in re.finditer(r"^impl<const D: usize> System<D>", text, re.M)
    ]
    pack = block("\n".join(chains.values()), r"pub trait Pack<")
    mesh = block("\n".join(chains.values()), r"impl PackMesh ")
    heads = [head for text in chains.values() for head in re.findall(r"^pub fn [^{]*", text, re.M)]
    beside = sum("dyn Pack<" in head for head in heads) + len(re.findall(r"^    pub fn ", mesh, re.M))
    follow = block((ROOT / "solver/src/continuation/follow.rs").read_text(), r"pub\(super\) fn follow\(")
    tuning = block((ROOT / "solver/src/continuation/tuning.rs").read_text(), r"pub struct Tuning ")
    steering = [*sources("solver/src/continuation").values(), (ROOT / "solver/src/newton.rs").read_text()]
    consts = sum(len(re.findall(r"^\s*(?:pub(?:\([a-z ]+\))? )?const [A-Z_]+: (?:f64|usize)", t, re.M)) for t in steering)
    item = r"^\s*pub (?:fn|struct|enum|trait|type|const|static|mod) (\w+)"
    public = [name for text in solver.values() for name in re.findall(item, text, re.M)]
    outside = {word for folder in OUTSIDE for text in sources(folder).values() for word in re.findall(r"\w+", text)}
    return [
        ("fields of `System`", len(fields)),
        ("methods of `System`, in so many files", f"{sum(map(functions, parts))} in {len(methods)}"),
        ("methods behind `dyn Pack`", functions(pack)),
        ("functions on what it hands out, with the methods of `PackMesh`", beside),
        ("lines of the loop along a path, `Continuation::follow`", follow.count("\n") + 1),
        ("numbers in the table of `tuning.rs`", len(re.findall(r"^    pub \w+:", tuning, re.M))),
        ("numbers with a name of their own beside it, in `continuation/` and `newton.rs`", consts),
        ("Newton loops along a path", sum(t.count("fn iterate<") for t in solver.values())),
        ("public items of `solver`", len(public)),
        ("of these, types and numbers that nothing outside names, but that what it names holds", sum(name not in outside for name in public)),
        ("lines of `continuation/`", sum(t.count("\n") for t in sources("solver/src/continuation").values())),
    ]


def main():
    table = HEAD + "".join(f"| {name} | {value} |\n" for name, value in rows())
    print(table, end="")
    if "--write" in sys.argv[1:]:
        text = PAGE.read_text()
        begin = text.index(HEAD)
        end = text.find("\n\n", begin)
        PAGE.write_text(text[:begin] + table + (text[end + 1 :] if end >= 0 else ""))


main()
