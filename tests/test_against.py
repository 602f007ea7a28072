"""The comparison with another revision notices what got slower, larger or impossible."""

import time

import pytest

from tests.benchmarks import against


class Costs:
    """A revision whose costs are known; each measurement adds the next of some disturbances."""

    def __init__(self, cost, size=1000, noise=(1.5, 1.3, 1.0)):
        self.cost, self.size, self.noise, self.result = cost, size, list(noise), [1.0, 0.5]

    def call(self, title, seconds):
        return self.disturbed()

    def command(self, title):
        return self.disturbed()

    def build(self, title):
        return self.disturbed()

    def disturbed(self):
        if isinstance(self.cost, str):
            return self.cost
        self.noise.append(self.noise.pop(0))
        return self.cost * self.noise[-1]


TITLES = ["evaluate_jump", "command laws", "build of rod, rigid"]


@pytest.mark.parametrize("title", TITLES)
def test_twelve_percent_more_are_too_much(title):
    lines = against.ratios(Costs(1.0), Costs(1.12), [title], 3)
    assert lines[title]["ratio"] == pytest.approx(1.12)
    assert against.failed(lines) == [title]


@pytest.mark.parametrize("title", TITLES)
def test_eight_percent_more_are_within_the_limit_however_large_the_times(title):
    assert against.failed(against.ratios(Costs(1e6), Costs(1.08e6), [title], 3)) == []


def test_noise_is_not_a_slower_revision():
    noise = (1.9, 1.8, 1.7, 1.9, 1.0)  # the least comes after the first rounds
    assert against.failed(against.ratios(Costs(1.0), Costs(1.0, noise=noise), TITLES[:1], 3)) == []


def test_a_larger_library_is_too_much():
    title = TITLES[-1]
    lines = against.ratios(Costs(1.0), Costs(1.0, size=1101), [title], 1)
    assert against.failed(lines) == [f"library, {title}"]


def test_what_only_the_other_revision_lacks_is_said_and_does_not_fail(capsys):
    lines = against.ratios(Costs("TypeError: no"), Costs(1.0), TITLES[:1], 3)
    assert against.failed(lines) == []
    assert "not compared (old: TypeError: no)" in capsys.readouterr().out


def test_what_this_checkout_lacks_fails():
    lines = against.ratios(Costs(1.0), Costs("TypeError: no"), TITLES[:1], 3)
    assert against.failed(lines) == TITLES[:1]


def test_another_result_is_not_compared_and_fails():
    other = Costs(1.0)
    other.result = [1.0, 0.5001]
    lines = against.ratios(Costs(1.0), other, TITLES[:1], 3)
    assert against.failed(lines) == TITLES[:1]


def test_the_least_time_of_a_call_is_processor_time():
    assert against.least_of(lambda: time.sleep(1e-3), 1e-3) < 5e-4
    assert against.least_of(lambda: sum(range(20000)), 5e-3) > 5e-5


@pytest.mark.parametrize("title", [t for t in against.CALLS if " arm" not in t])
def test_each_call_does_something(title):
    assert against.CALLS[title]()() is not None
