"""Sentences on words that do not exist name the word that was meant, and none where nothing is
near.
"""

from hypothesis import given, settings
from hypothesis import strategies as st

from tippetop.errors import InputError, nearest, unknown_key


@settings(max_examples=50, deadline=None)
@given(
    st.text("abcXY_", max_size=12), st.lists(st.text("abcXY_", min_size=1, max_size=8), max_size=5)
)
def test_what_is_guessed_is_one_of_the_known(word: str, known: list[str]) -> None:
    assert nearest(word, known) in {None, *known}


def test_a_part_of_a_name_counts() -> None:
    assert nearest("Drilling", ["rolling", "leine-glocker-drilling"]) == "leine-glocker-drilling"


def test_an_unknown_key_is_looked_for_everywhere() -> None:
    """First in its own table, then in the others; what is known is listed either way."""
    everywhere = ["friction.mu", "initial.theta"]
    assert unknown_key("initial.omega", ["theta", "omega3"], everywhere) == (
        "unknown key `initial.omega`; did you mean `initial.omega3`? The keys of `initial` are "
        "theta, omega3."
    )
    assert "did you mean `friction.mu`?" in unknown_key(
        "initial.mu", ["theta", "omega3"], everywhere
    )
    assert "did you mean" not in unknown_key(
        "friction.eps", ["law", "mu"], ["initial.psi"]
    )  # three letters in disorder
    assert "did you mean `initial.theta`?" in unknown_key(
        "parameters.theta", ["m", "theta0"], everywhere
    )
    assert (
        unknown_key("zzzz", ["system", "form"]) == "unknown key `zzzz`. The keys are system, form."
    )


def test_of_many_faults_the_first_are_reported_and_the_others_counted() -> None:
    for count, last in ((1, "fault 0."), (21, "fault 20."), (22, "2 more faults were found.")):
        sentences = InputError([f"fault {i}." for i in range(count)]).sentences
        assert len(sentences) == min(count, 21)
        assert (sentences[0], sentences[-1]) == ("fault 0.", last)
