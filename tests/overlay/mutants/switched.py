"""Many mutants in one program, each behind a switch, so that they are compiled once.

Statements become `if (chosen == 7) { mutant } else { code }`, conditions and initial values
`chosen == 7 ? (mutant) : (code)`. What is none of these, or does not compile so, is for a build of
its own.
"""
import re

header_name = "chosen_mutant.h"
header = """#pragma once
#include <cstdlib>
namespace mutants {
inline const int chosen = std::getenv("ROMANO_MUTANT") ? std::atoi(std::getenv("ROMANO_MUTANT")) : 0;
}
"""
include = f'#include "{header_name}"'

condition = re.compile(r"^((?:\} else )?(?:if|while) \()(.*)(\) \{)$")
initial_value = re.compile(r"^((?:[\w:<>]+ )+\w+ = )(.*)(;)(?:\s*//.*)?$")


def is_chosen(number):
    return f"mutants::chosen == {number}"


def without_comments(lines):
    return " ".join(line.split("//")[0].strip() for line in lines).strip()


def are_statements(lines):
    text = without_comments(lines)
    return not text or (text[-1] in ";}" and all(text.count(a) == text.count(b) for a, b in ("()", "{}", "[]")))


def behind_switch(number, taken, put):
    """The lines that have both in them; None when they are neither statements nor one expression."""
    taken, put = [line.strip() for line in taken], [line.strip() for line in put]
    before = []
    while taken and put and taken[0] == put[0]:
        before.append(taken.pop(0))
        put.pop(0)
    behind = []
    while taken and put and taken[-1] == put[-1]:
        behind.insert(0, taken.pop())
        put.pop()
    if len(taken) == len(put) == 1:
        for form in (condition, initial_value):
            old, new = form.match(taken[0]), form.match(put[0])
            if old and new and old[1] == new[1]:
                value = f"{is_chosen(number)} ? ({new[2]}) : ({old[2]})"
                return [*before, old[1] + value + old[3], *behind]
    if not (are_statements(taken) and are_statements(put)):
        return None
    return [*before, f"if ({is_chosen(number)}) {{", *put, "} else {", *taken, "}", *behind]


def put_switches(mutants, read, change):
    """`mutants` by their numbers. Returns the changed files' texts, and the numbers of those that are in them.

    `read` gives a file's text, `change` a text with other lines instead of a mutant's, or raises
    ValueError when the mutant does not fit."""
    texts, fitting = {}, []
    for number, mutant in mutants.items():
        put = behind_switch(number, mutant.taken, mutant.put)
        if put is None:
            continue
        text = texts.get(mutant.file) or include + "\n" + read(mutant.file)
        try:
            texts[mutant.file] = change(mutant, text, put)
            fitting.append(number)
        except ValueError:  # another mutant stands in its lines
            pass
    return texts, fitting


def at_fault(output, texts):
    """The numbers of the mutants to which a compiler's errors belong; those of a whole file when none is near."""
    numbers = set()
    for file, text in texts.items():
        lines = text.splitlines()
        for error in re.finditer(re.escape(file) + r":(\d+):\d+: error", output):
            above = "\n".join(lines[:int(error[1])])
            near = re.findall(r"mutants::chosen == (\d+)", above) or re.findall(r"mutants::chosen == (\d+)", text)
            numbers.add(int(near[-1]))
    return numbers
