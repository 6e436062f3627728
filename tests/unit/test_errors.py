"""Errors travel: through copies, pickles and pools of processes."""

from __future__ import annotations

import copy
import pickle
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context

import pytest

import subskin as ss
from subskin import errors

ALL = [kind for kind in vars(errors).values() if isinstance(kind, type) and issubclass(kind, errors.SubskinError)]


@pytest.mark.parametrize("kind", ALL)
@pytest.mark.parametrize("send", [copy.copy, copy.deepcopy, lambda error: pickle.loads(pickle.dumps(error))])
def test_an_error_arrives_as_it_was(kind, send):
    sent = kind("young = -1", "has to be > 0", "young=0.4e6")
    came = send(sent)
    assert type(came) is kind
    assert (came.seen, came.rule, came.fix, str(came)) == (sent.seen, sent.rule, sent.fix, str(sent))


def test_a_worker_of_a_pool_hands_on_what_it_raised():
    with ProcessPoolExecutor(1, mp_context=get_context("spawn")) as pool:
        with pytest.raises(errors.InvalidValueError, match="young = -1"):
            pool.submit(ss.Material, -1.0).result(timeout=60)
        assert pool.submit(ss.Material, 1.0).result(timeout=60).young == 1.0
