"""Printed: both ways of a fitted transmission as one file of C."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from ..tape import as_c
from .newton import MOST_STEPS, FittedWay
from .way import Side


def as_file(mechanism: str, name: str, ways: Mapping[str, FittedWay]) -> str:
    """Return a file of C99, see `FittedTransmission.write_c`.

    Args:
        mechanism: name of the mechanism.
        name: with which functions begin.
        ways: rest of the name of each function to what it computes.

    Raises:
        ArgumentError: the name is no identifier.
    """
    printed = [
        as_c(program, f"{name}_{kind}_{what}").replace("\nvoid ", "\nstatic void ", 1)
        for kind, way in ways.items()
        for what, program in way.programs.items()
    ]
    functions = [_function(f"{name}_{kind}", way) for kind, way in ways.items()]
    head = [line for kind, way in ways.items() for line in _told(f"{name}_{kind}", way)]
    title = f"Transmission of {mechanism}, by Newton's method."
    lines = [title, "", *head, "It is compiled as C99 or later, and needs no library."]
    told = "\n".join(f"   {line}".rstrip() for line in lines).replace("*/", "* /").strip()
    return "\n".join([f"/* {told} */", "", *printed, *functions])


def _told(name: str, way: FittedWay) -> Iterator[str]:
    """Yield what the head of the file says of a function."""
    yield f"{_declared(name, way)};"
    yield "  returns 0; 1 where a position is outside of its range, or loops do not close there,"
    yield "  and then writes nothing."
    yield f"  {way.given.role}, and between which positions:"
    each = zip(way.given.names, way.low.tolist(), way.high.tolist(), _units(way.given), strict=True)
    for index, (coordinate, low, high, unit) in enumerate(each):
        yield f"    [{index}] {coordinate}: {low!r} to {high!r} {unit}"
    yield f"  {way.found.role}, off by at most {way.error.position:.1e} where it was measured:"
    for index, pair in enumerate(zip(way.found.names, _units(way.found), strict=True)):
        yield f"    [{index}] {' '.join(pair)}"
    yield (
        f"  jacobian, row by row d {way.found.role} / d {way.given.role}, off by at most "
        f"{way.error.jacobian:.1e};"
    )
    yield "    0 in its place leaves it out, which takes less time"
    yield ""


def _units(side: Side) -> list[str]:
    return ["m" if slides else "rad" for slides in side.slides]


def _declared(name: str, way: FittedWay) -> str:
    given, found, count = way.given.role, way.found.role, len(way.low)
    return (
        f"int {name}(const double {given}[{count}], double {found}[{count}], "
        f"double jacobian[{count * count}])"
    )


def _function(name: str, way: FittedWay) -> str:
    """Return the function that looks at the range first."""
    given, found, count = way.given.role, way.found.role, len(way.low)
    low, high = (", ".join(map(float.hex, ends.tolist())) for ends in (way.low, way.high))
    closed = way.start.outputs
    tried = "".join(
        f"""
    {name}_start(1, inputs, x);
    x[{closed}] = HUGE_VAL;
    for (k = 0; k < {MOST_STEPS}; k++) {{
        {name}_step_{order}(1, inputs, x);
        if (!(x[{closed}] <= 1.0))
            continue;
        if (jacobian) {{
            {name}_slopes_{order}(1, inputs, outputs);
            for (k = 0; k < {count * count}; k++)
                jacobian[k] = outputs[{count} + k];
        }} else
            {name}_values(1, inputs, outputs);
        for (k = 0; k < {count}; k++)
            {found}[k] = outputs[k];
        return 0;
    }}"""
        for order in range(len(way.steps))
    )
    return f"""\
{_declared(name, way)}
{{
    static const double low[{count}] = {{{low}}}, high[{count}] = {{{high}}};
    const double *inputs[{count + closed + 1}];
    double x[{closed + 1}], outputs[{count + count * count}];
    int k;
    for (k = 0; k < {count}; k++) {{
        if (!({given}[k] >= low[k] && {given}[k] <= high[k]))
            return 1;
        inputs[k] = &{given}[k];
    }}
    for (k = 0; k <= {closed}; k++)
        inputs[{count} + k] = &x[k];{tried}
    return 1;
}}
"""
