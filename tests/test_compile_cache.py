"""Compiled programs are kept for commands, for this machine alone, and never in the way of anything."""

import json
import os
import subprocess
import sys

import pytest
from jax._src.lru_cache import LRUCache

from dshpm_jax import _compile_cache
from dshpm_jax._compile_cache import cache_folder, cache_programs, fingerprint

COMPILE = """
import json, sys, jax, jax.monitoring
from dshpm_jax._compile_cache import cache_programs
events = []
jax.monitoring.register_event_listener(lambda event, **_: events.append(event.rsplit("/", 1)[-1]))
cache_programs()
jax.jit(lambda x: 2 * x)(1.0)
print(json.dumps([events.count("cache_hits"), events.count("cache_misses")]))
"""
IMPORT = """
import sys, jax
before = dict(jax.config.values)
import dshpm_jax
dshpm_jax.label, dshpm_jax.Driver
sys.exit(jax.config.values != before)
"""


@pytest.fixture
def user(tmp_path, monkeypatch):
    """The folder of somebody who has set nothing."""
    for name in ("DSHPM_CACHE", "XDG_CACHE_HOME", "JAX_COMPILATION_CACHE_DIR", "LOCALAPPDATA"):
        monkeypatch.delenv(name, raising=False)
    monkeypatch.setenv("HOME", str(tmp_path / "user"))
    _compile_cache._made.cache_clear()
    yield tmp_path / "user"
    _compile_cache._made.cache_clear()


def python(code):
    return subprocess.run([sys.executable, "-c", code], capture_output=True, text=True)


def test_a_second_process_compiles_nothing(user):
    assert json.loads(python(COMPILE).stdout) == [0, 1]
    (folder,) = (user / ".cache" / "dshpm-jax").iterdir()
    (program,) = folder.iterdir()
    assert folder.stat().st_mode & 0o077 == 0 and program.name.startswith("jit_")
    assert json.loads(python(COMPILE).stdout) == [1, 0]


def test_importing_the_package_leaves_jax_as_it_is(user):
    assert python(IMPORT).returncode == 0 and not user.exists()


def test_where_programs_are_kept(user, tmp_path, monkeypatch):
    assert cache_folder().parent == user / ".cache" / "dshpm-jax"
    monkeypatch.setenv("XDG_CACHE_HOME", "not/absolute")
    _compile_cache._made.cache_clear()
    assert cache_folder().parent == user / ".cache" / "dshpm-jax"
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "caches"))
    _compile_cache._made.cache_clear()
    assert cache_folder().parent == tmp_path / "caches" / "dshpm-jax"
    monkeypatch.setenv("DSHPM_CACHE", str(tmp_path / "mine"))
    assert cache_folder().parent == tmp_path / "mine" and cache_folder().name.endswith(fingerprint())


def test_programs_of_another_processor_are_elsewhere(user, monkeypatch):
    here = fingerprint()
    monkeypatch.setattr(_compile_cache, "_processor", lambda: ["flags: none"])
    fingerprint.cache_clear()
    assert fingerprint() != here
    fingerprint.cache_clear()


@pytest.mark.parametrize(
    "variables", [{"DSHPM_CACHE": ""}, {"HOME": ""}, {"HOME": os.devnull}, {"JAX_COMPILATION_CACHE_DIR": "there"}]
)
def test_nothing_is_kept(user, monkeypatch, capsys, variables):
    for name, value in variables.items():
        monkeypatch.setenv(name, value)
    assert cache_folder() is None and not user.exists()
    assert capsys.readouterr() == ("", "")


def test_a_folder_of_somebody_else_is_left_alone(user, monkeypatch):
    monkeypatch.setattr(os, "getuid", lambda: 1234)
    monkeypatch.setattr(_compile_cache, "_ADMINISTRATOR", -1)
    assert cache_folder() is None


def test_a_folder_that_was_asked_for_and_cannot_be_is_said_once(user, monkeypatch, capsys):
    monkeypatch.setenv("DSHPM_CACHE", os.devnull)
    cache_programs()
    cache_programs()
    assert "compiled programs cannot be kept there" in capsys.readouterr().err.rstrip("\n")
    cache_programs()
    assert capsys.readouterr().err == ""


def test_programs_appear_whole_or_not_at_all(tmp_path, monkeypatch):
    monkeypatch.setattr(LRUCache, "put", LRUCache.put)  # put back afterwards
    _compile_cache._write_whole_files()
    kept = LRUCache(str(tmp_path), max_size=-1)
    kept.put("one", b"program")
    assert kept.get("one") == b"program" and [p.name for p in tmp_path.iterdir()] == ["one-cache"]

    def full(*_):
        raise OSError("No space left on device")

    monkeypatch.setattr(os, "replace", full)
    with pytest.raises(OSError, match="No space"):
        kept.put("two", b"program")
    assert kept.get("two") is None and [p.name for p in tmp_path.iterdir()] == ["one-cache"]
