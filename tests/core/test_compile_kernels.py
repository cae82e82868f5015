"""Compiled kernels stand in the user's cache under a key of all their sources; where there is none, in a folder for the moment."""

from __future__ import annotations

import numba

from vcmm.core import _compile_kernels as compiling


def test_the_key_follows_every_kernel_file(tmp_path):
    (tmp_path / "room").mkdir()
    first, second = tmp_path / "a_kernels.py", tmp_path / "room" / "b_kernels.py"
    first.write_text("x = 1")
    second.write_text("y = 1")
    before = compiling.sources_key(tmp_path)
    second.write_text("y = 2")
    after = compiling.sources_key(tmp_path)
    (tmp_path / "room" / "other.py").write_text("z = 1")
    assert before != after == compiling.sources_key(tmp_path)
    assert len(after) == 16


def test_the_folder_of_the_user(tmp_path, monkeypatch):
    monkeypatch.setitem(vars(numba.config), "CACHE_DIR", "")
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    folder, kept = compiling.cache_folder()
    assert (folder, kept) == (tmp_path / "vcmm" / "numba" / compiling.sources_key(), True)
    assert folder.is_dir()


def test_a_named_folder_wins(tmp_path, monkeypatch):
    monkeypatch.setitem(vars(numba.config), "CACHE_DIR", str(tmp_path))
    assert compiling.cache_folder()[0].parent == tmp_path


def test_without_a_cache_a_folder_for_the_moment_is_used(tmp_path, monkeypatch):
    (tmp_path / "file").write_text("")
    monkeypatch.setitem(vars(numba.config), "CACHE_DIR", str(tmp_path / "file" / "below"))
    folder, kept = compiling.cache_folder()
    assert not kept
    assert folder.is_dir()
    folder.rmdir()


def test_the_settings_of_others_stay(tmp_path, monkeypatch):
    monkeypatch.setitem(vars(numba.config), "CACHE_DIR", "mine")
    monkeypatch.setattr(compiling, "FOLDER", tmp_path)

    @compiling.njit(cache=True)
    def twice(x):
        return 2 * x

    assert vars(numba.config)["CACHE_DIR"] == "mine"
    assert twice(21) == 42
    assert list(tmp_path.rglob("*.nbi"))


def test_every_kernel_file_compiles_through_this_one():
    for file in compiling.PACKAGE.rglob("_*_kernels.py"):
        text = file.read_text()
        ours = "from vcmm.core._compile_kernels import njit" in text
        # a file of intrinsics alone compiles nothing: it is part of the kernels that call it
        assert file.name == "_compile_kernels.py" or ours or ("njit" not in text and "intrinsic(" in text), (
            file
        )
        assert file.name == "_compile_kernels.py" or "import numba" not in text, file
