"""Every error of a model is a sentence of one form: `key` must ..., but is ...."""

from typing import Annotated, Any, Literal

import pytest
from pydantic import BaseModel, ConfigDict, Field, FiniteFloat, ValidationError

from tippetop.scenario.sentences import error_sentence


class Model(BaseModel):
    """A field of every sort that scenarios and plans are made of."""

    model_config = ConfigDict(extra="forbid", strict=True)
    above: Annotated[float, Field(gt=0)] = 1.0
    least: Annotated[float, Field(ge=0)] = 1.0
    below: Annotated[float, Field(lt=1)] = 0.5
    most: Annotated[float, Field(le=1)] = 0.5
    finite: FiniteFloat = 0.0
    number: float = 0.0
    whole: int = 0
    flag: bool = False
    text: str = ""
    numbers: Annotated[list[float], Field(min_length=2, max_length=3)] = [0.0, 1.0]
    table: dict[str, float] = {}
    choice: Literal["a", "b"] = "a"
    inner: "Model | None" = None


CASES = [
    ({"above": 0.0}, "`above` must be greater than 0, but is 0.0."),
    ({"least": -1.0}, "`least` must be at least 0.0, but is -1.0."),
    ({"below": 1.0}, "`below` must be less than 1, but is 1.0."),
    ({"most": 2.0}, "`most` must be less than or equal to 1, but is 2.0."),
    ({"finite": float("inf")}, "`finite` must be a finite number, but is inf."),
    ({"number": "1"}, "`number` must be a number, but is '1'."),
    ({"whole": 1.5}, "`whole` must be a whole number, but is 1.5."),
    ({"flag": 1}, "`flag` must be true or false, but is 1."),
    ({"text": 1}, "`text` must be a string, but is 1."),
    ({"numbers": 1.0}, "`numbers` must be a list, but is 1.0."),
    ({"numbers": [1.0]}, "`numbers` must have at least 2 items, but is [1.0]."),
    ({"numbers": [1.0] * 4}, "`numbers` must have at most 3 items, but is [1.0, 1.0, 1.0, 1.0]."),
    ({"table": 1}, "`table` must be a table, but is 1."),
    ({"choice": "c"}, "`choice` must be 'a' or 'b', but is 'c'."),
    ({"inner": {"numbr": 1.0}}, "unknown key `inner.numbr`; did you mean `inner.number`?"),
    ({"text": {"a": 1}}, "`text` must be a string, but is a table."),
]


def sentence(document: dict[str, Any]) -> str:
    with pytest.raises(ValidationError) as found:
        Model.model_validate(document)
    (error,) = found.value.errors(include_url=False)
    return error_sentence(error, ".".join(map(str, error["loc"])), list(Model.model_fields))


@pytest.mark.parametrize(("document", "expected"), CASES)
def test_an_error_says_what_must_hold_and_what_was_found(
    document: dict[str, Any], expected: str
) -> None:
    assert sentence(document).startswith(expected)


def test_what_is_long_is_cut() -> None:
    found = sentence({"number": "x" * 1000})
    assert found.startswith("`number` must be a number, but is 'xxx")
    assert found.endswith("....")
    assert len(found) < 110


def test_what_is_missing_is_said() -> None:
    class Needs(BaseModel):
        m: float

    with pytest.raises(ValidationError) as found:
        Needs.model_validate({})
    assert error_sentence(found.value.errors()[0], "parameters.m", ["m"]) == (
        "`parameters.m` must be given, but is missing."
    )
