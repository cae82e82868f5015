"""vcmm.answer.evaluation.streams: the rule, word for word; both backends; every law's samples against the law itself."""

from __future__ import annotations

import hashlib
import math
import subprocess
import sys

import numpy as np
import pytest

from vcmm.answer.evaluation import streams
from vcmm.core.errors import ModelLimit, UsageError
from vcmm.core.laws import (
    Arcsine,
    CurvilinearTrapezoidal,
    Law,
    MultivariateSamples,
    Normal,
    Samples,
    StudentT,
    Trapezoidal,
    Triangular,
    Uniform,
)

LAWS = [
    Normal(2.0),
    StudentT(0.5, 3.0),
    StudentT(1.0, 13.0),
    Uniform(3.0),
    Triangular(1.0),
    Trapezoidal(2.0, 0.5),
    Arcsine(0.5),
    CurvilinearTrapezoidal(1.0, 0.3),
    Samples(np.arange(1000.0) ** 1.5),
]


def lanes(n: int) -> np.ndarray:
    return np.stack([np.arange(n), np.full(n, 7)], axis=1).astype(np.uint32)


def philox(counter: tuple[int, ...], key: tuple[int, int]) -> list[int]:
    """Philox4x32-10 on Python integers, written from Salmon et al. 2011, independent of the module."""
    (a, b, c, d), (k0, k1) = counter, key
    for _ in range(10):
        p, q = 0xD2511F53 * a, 0xCD9E8D57 * c
        a, b, c, d = (q >> 32) ^ b ^ k0, q % 2**32, (p >> 32) ^ d ^ k1, p % 2**32
        k0, k1 = (k0 + 0x9E3779B9) % 2**32, (k1 + 0xBB67AE85) % 2**32
    return [a, b, c, d]


# Random123 distribution, file kat_vectors, lines "philox4x32 10": counter, key, result
KAT = [
    ((0, 0, 0, 0), (0, 0), "6627e8d5 e169c58d bc57ac4c 9b00dbd8"),
    ((2**32 - 1,) * 4, (2**32 - 1,) * 2, "408f276d 41c83b0e a20bc7c6 6d5451fd"),
    (
        (0x243F6A88, 0x85A308D3, 0x13198A2E, 0x03707344),
        (0xA4093822, 0x299F31D0),
        "d16cfe09 94fdcceb 5001e420 24126ea1",
    ),
]


@pytest.mark.parametrize(("counter", "key", "expected"), KAT)
def test_random123_known_answers(counter, key, expected):
    lane = np.array([counter[2:]], np.uint32)
    words = streams._philox(np.array([counter[0]]), counter[1], lane, np.array([key], np.uint32))
    assert " ".join(f"{int(w):08x}" for w in words.ravel()) == expected
    assert " ".join(f"{w:08x}" for w in philox(counter, key)) == expected


def test_key_is_the_hash_of_seed_and_name():
    digest = hashlib.blake2b(b"17\nprobe[tip].radius", digest_size=8).digest()
    expected = tuple(int.from_bytes(digest[i : i + 4], "little") for i in (0, 4))
    assert streams.key(17, "probe[tip].radius") == expected


def test_one_word_follows_the_rule():
    # trial 5000 = block 2 (2 * 2048 = 4096), place 904 = word 1 (904 // 512), counter 904 - 512 = 392
    key = streams.key(1, "a")
    assert streams.bits(key, 3, 9, 5000, 1)[0] == philox((392, 2, 3, 9), key)[1]


def test_numbers_never_change():
    """Frozen: these values belong to the rule. Do not edit them to make the test pass."""
    got = streams.draw(1, "repeatability", np.array([[0, 0], [1, 5]]), Normal(1.0), 2046, 3)
    word = streams.bits(streams.key(1, "repeatability"), 1, 5, 2047, 1)[0]
    assert word == FROZEN_WORD
    np.testing.assert_array_equal(got, FROZEN)


FROZEN_WORD = 504892818
FROZEN = np.array(
    [
        [0.7537364363670349, 2.177597999572754],
        [0.2594631314277649, -1.5651212930679321],
        [0.22276754677295685, 0.5952056050300598],
    ]
)


@pytest.mark.parametrize(
    ("start", "count"), [(0, 5000), (1, 1), (2040, 20), (511, 2), (4095, 3000), (10**10, 700)]
)
def test_any_slice_gives_the_same_numbers(start, count):
    """Numbers of a trial do not depend on where the call starts: whole, short and straddling ranges agree."""
    law = StudentT(1.0, 4.0)
    base = start - start % 2048
    whole = streams.draw(3, "x", lanes(3), law, base, start - base + count + 600)
    np.testing.assert_array_equal(
        streams.draw(3, "x", lanes(3), law, start, count), whole[start - base : start - base + count]
    )
    bits = streams.bits(streams.key(3, "x"), 1, 7, start, count)
    np.testing.assert_array_equal(streams.table(law).lookup(bits), whole[start - base :][:count, 1])


def test_names_components_and_copies_are_streams_of_their_own():
    one = streams.draw(3, "x", lanes(3), Normal(1.0), 0, 4096)
    more = streams.draw(3, "x", np.concatenate([[[9, 9]], lanes(5)]), Normal(1.0), 0, 4096)
    np.testing.assert_array_equal(more[:, 1:4], one)  # more lanes change no other lane
    other = [
        streams.draw(3, "y", lanes(1), Normal(1.0), 0, 4096)[:, 0],
        streams.draw(4, "x", lanes(1), Normal(1.0), 0, 4096)[:, 0],
        *more.T,
    ]
    correlation = np.corrcoef(other) - np.eye(len(other))
    assert np.abs(correlation).max() < 5 / math.sqrt(4096)


def test_successive_trials_are_uncorrelated():
    x = streams.draw(8, "x", lanes(1), Normal(1.0), 0, 100_000)[:, 0]
    for lag in (1, 2, 512, 2048):
        assert abs(np.mean(x[lag:] * x[:-lag])) < 5 / math.sqrt(100_000)


@pytest.mark.parametrize("law", LAWS, ids=lambda law: law.name)
def test_samples_follow_the_law(law: Law):
    """Kolmogorov-Smirnov distance within its 0.1 % point, 1.95 / sqrt(n); mean and u within 5 of their errors."""
    n = 200_000
    x = np.sort(streams.draw(5, "law", lanes(1), law, 0, n)[:, 0])
    below = law.cdf(x)
    # the distance to a stepped law counts the whole step: compare at both sides of each sample
    left = law.cdf(np.nextafter(x, -np.inf))
    rank = np.arange(n) / n
    distance = max((rank - below).max(), (left - rank - 1 / n).max())
    assert distance < 1.95 / math.sqrt(n)
    assert abs(x.mean() - law.mean) < 5 * law.u / math.sqrt(n)
    if law.dof > 4:
        kurtosis = np.mean(((x - law.mean) / law.u) ** 4)
        assert abs(x.std() / law.u - 1) < 5 * math.sqrt((kurtosis - 1) / 4 / n)


@pytest.mark.parametrize(
    "law", [law for law in LAWS if not isinstance(law, Samples)], ids=lambda law: law.name
)
def test_table_gives_the_quantile_of_its_word(law: Law):
    shape = law.shape
    word = np.concatenate([streams.bits((1, 2), 0, 0, 0, 20_000), [0, 1, 2, 3, 2**32 - 1, 2**32 - 2]]).astype(
        np.uint32
    )
    tail = np.maximum(word >> 1, 1) * 2.0**-32
    expected = np.where(word & 1, 1, -1) * shape.isf(np.minimum(tail, 0.5))
    got = streams.table(shape).lookup(word)
    scale = np.maximum(np.abs(expected), 0.1 * min(shape.u, 2.0))
    assert np.abs((got - expected) / scale).max() < 4e-6


@pytest.mark.parametrize("law", [Normal(1.0), StudentT(1.0, 4.0), StudentT(1.0, 9.0), Arcsine(1.0)], ids=str)
def test_standard_deviation_of_the_table_is_right(law: Law):
    """Integral of value^2 over v by the exact moments of each straight piece: u to 1e-5 (StudentT 4: 3e-5)."""
    table = streams.table(law.shape)
    k = np.arange(len(table.value) - 1)
    width = np.ldexp(1 / 256, (k >> 8) - 31)
    a, d = table.value[:-1].astype(float), table.slope[:-1].astype(float)
    variance = np.sum(width * (a * a + a * d + d * d / 3)) + 2.0**-31 * float(table.value[0]) ** 2
    assert math.sqrt(variance) == pytest.approx(law.u, rel=4e-5)


@pytest.mark.parametrize("law", LAWS, ids=lambda law: law.name)
def test_numba_gives_the_bits_of_numpy(law: Law):
    fast = streams._load_kernels()
    if fast is None:
        pytest.skip("numba is not installed or cannot keep its cache")
    keys = np.tile(np.array(streams.key(2, "n"), np.uint32), (5, 1))
    for start, count in ((0, 2048), (100, 4096), (2048, 600)):
        one, two = np.empty((5, count)), np.empty((5, count))
        streams.standard(law.shape, keys, lanes(5), start, one, None)
        streams.standard(law.shape, keys, lanes(5), start, two, fast)
        np.testing.assert_array_equal(one, two)


def test_joint_samples_keep_their_rows():
    values = np.array([[1.0, 10.0, 100.0], [2.0, 20.0, 200.0], [3.0, 30.0, 300.0]])
    law = MultivariateSamples(values)
    which = np.array([[0, 4], [2, 4], [0, 5]])  # components 0 and 2 of copy 4, component 0 of copy 5
    x = streams.draw(1, "j", which, law, 0, 3000)
    np.testing.assert_array_equal(x[:, 1], 100 * x[:, 0])
    assert abs(np.corrcoef(x[:, 0], x[:, 2])[0, 1]) < 0.1
    assert np.bincount(x[:, 0].astype(int))[1:] == pytest.approx(1000, abs=130)  # sd sqrt(3000 * 2/9) = 26


def test_copy_code():
    assert streams.copy_code(17) == streams.copy_code("17") == streams.copy_code(np.int64(17)) == 17
    digest = hashlib.blake2b(b"pose B", digest_size=4).digest()
    assert streams.copy_code("pose B") == 2**31 + int.from_bytes(digest, "little") // 2
    codes = {streams.copy_code(label) for label in ("A", "B", "-1", "017", "1.0", "", "2147483648")}
    assert len(codes) == 7
    assert min(codes) >= 2**31


def test_limits_are_refused():
    with pytest.raises(ModelLimit, match="2\\^43"):
        streams.draw(1, "x", lanes(1), Normal(1.0), 2**43, 1)
    with pytest.raises(ModelLimit, match="use another seed"):
        streams.bits((1, 2), 0, 0, -1, 4)
    with pytest.raises(UsageError, match="by index"):
        streams.table(Samples(np.arange(3.0)))


def test_without_a_folder_for_compiled_code_numpy_is_used(monkeypatch):
    from vcmm.core import _compile_kernels

    monkeypatch.setattr(_compile_kernels, "KEPT", False)
    assert streams._load_kernels.__wrapped__() is None


def test_normal_numbers_need_neither_scipy_nor_numba():
    code = (
        "import sys, numpy as np; from vcmm.core import laws; from vcmm.answer.evaluation import streams;"
        "streams.draw(1, 'x', np.zeros((1, 2)), laws.Normal(1.0), 0, 100);"
        "print('scipy' in sys.modules, 'numba' in sys.modules)"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.split() == ["False", "False"]
