"""The parts of the server that need no server: paths, origins, people, headers, the command."""

import json
import os
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st
from tornado.httputil import HTTPHeaders

from markermend.errors import BadInput
from markermend.review.store import Store
from markermend_app.serving.accounts import People, fits, hashed
from markermend_app.serving.doors import Doors, doors, is_loopback, loopback_doors, plain_origin
from markermend_app.serving.headers import Guarded, GuardedByTls
from markermend_app.serving.login import Tries
from markermend_app.state.desk import Desk
from markermend_app.state.intents import NEEDS, perform
from markermend_app.state.people import Person
from markermend_app.state.reach import Reach
from markermend_app.state.workspace import Workspace

from .conftest import METHODS, Command, Ticks, settle

OUTSIDE = (
    "/etc/passwd", "../secret.c3d", "a/../../secret.c3d", "./../secret.c3d", "..", "../", "/",
    "~", "~root/x.c3d", "~nobody-at-all/x", "link.c3d", "linked/secret.c3d", "loop.c3d",
    "C:\\Windows\\win.ini", "C:/Windows/win.ini", "c:take.c3d", "\\\\server\\share\\x.c3d",
    "//server/share/x.c3d", "..\\secret.c3d", "a\\..\\..\\secret.c3d", "\\\\?\\C:\\x", "\\\\.\\NUL",
    "file:///etc/passwd\n", "in\x00side.c3d", "in\x1b[2Jside.c3d", "\u202egnp.c3d",
    "x" * 5000, "x" * 5000 + "/..",
    "/proc/self/environ", "/dev/zero", "\ud800",
)  # fmt: skip
"""Paths that must not lead anywhere; beside the archive lies ``secret.c3d``."""
ODD_BUT_INSIDE = (
    "%2e%2e/secret.c3d", "%2e%2e%2fsecret.c3d", "..%2fsecret.c3d", "．．/secret.c3d",
    "....//secret.c3d",
    "%c0%ae%c0%ae/secret.c3d", "a/./../inside.c3d",
)  # fmt: skip
"""Paths that mean what they say: no encoding of a path is ever undone."""


@pytest.fixture
def archive(tmp_path: Path) -> Path:
    folder = tmp_path / "archive"
    (folder / "a").mkdir(parents=True)
    (folder / "inside.c3d").write_bytes(b"inside")
    (tmp_path / "secret.c3d").write_bytes(b"secret")
    if os.name == "posix":
        (folder / "link.c3d").symlink_to(tmp_path / "secret.c3d")
        (folder / "linked").symlink_to(tmp_path)
        (folder / "loop.c3d").symlink_to(folder / "loop.c3d")
        (folder / "good.c3d").symlink_to(folder / "inside.c3d")
    return folder


@pytest.mark.parametrize("path", OUTSIDE)
def test_no_path_leads_out_of_the_archive(archive: Path, path: str):
    if path in ("link.c3d", "linked/secret.c3d", "loop.c3d") and os.name != "posix":
        pytest.skip("links need rights here")
    with pytest.raises(BadInput, match="does not lie in the archive"):
        Reach(archive).inside(path)


@pytest.mark.parametrize("path", ODD_BUT_INSIDE)
def test_an_encoded_path_is_a_name_and_nothing_else(archive: Path, path: str):
    found = Reach(archive).inside(path)
    assert found.is_relative_to(archive.resolve())
    assert not found.exists() or found.read_bytes() == b"inside"


PIECES = [
    "..",
    ".",
    "a",
    "inside.c3d",
    "linked",
    "link.c3d",
    "/",
    "\\",
    "~",
    "C:",
    "%2e",
    "\0",
    " ",
]


@given(parts=st.lists(st.sampled_from(PIECES) | st.text(max_size=4), max_size=8))
def test_whatever_is_given_ends_inside_or_is_refused(
    tmp_path_factory: pytest.TempPathFactory, parts: list[str]
):
    base = tmp_path_factory.getbasetemp() / "reach"
    folder = base / "archive"
    if not folder.exists():
        (folder / "a").mkdir(parents=True)
        if os.name == "posix":
            (folder / "linked").symlink_to(base)
            (folder / "link.c3d").symlink_to(base / "secret.c3d")
    try:
        found = Reach(folder).inside("/".join(parts))
    except BadInput:
        return
    assert found.resolve().is_relative_to(folder.resolve())


def test_links_within_the_archive_are_followed(archive: Path):
    if os.name != "posix":
        pytest.skip("links need rights here")
    assert Reach(archive).inside("good.c3d").read_bytes() == b"inside"
    assert Reach(archive).inside(archive / "inside.c3d").name == "inside.c3d"


@pytest.fixture
def lab_desk(tmp_path: Path, take_path: Path) -> Iterator[tuple[Desk, Ticks]]:
    folder = tmp_path / "lab"
    folder.mkdir()
    inside = folder / "small.c3d"
    inside.write_bytes(take_path.read_bytes())
    ticks = Ticks()
    with Store(tmp_path / "store.sqlite") as store:
        work = Workspace(
            store, (inside,), methods=METHODS, ahead=0, reach=Reach(folder), most_upload=1000
        )
        desk = Desk(work, ticks, Person("anna", signed_in=True))
        desk.open(inside)
        settle(desk, ticks)
        yield desk, ticks
        desk.close()


def test_a_desk_of_a_lab_opens_writes_and_lists_the_archive_alone(
    lab_desk: tuple[Desk, Ticks], take_path: Path
):
    desk, ticks = lab_desk
    opened = desk.opened
    for path in (str(take_path), "../small.c3d", "~/small.c3d"):
        perform(desk, "open", path)
        settle(desk, ticks)
        assert "does not lie in the archive" in desk.message
    desk.workspace.store.remember(opened.take)
    desk.show_takes()
    assert {p.path for p in (*desk.takes.given, *desk.takes.beside, *desk.takes.recent)} == {
        opened.take.source.path
    }
    desk.close_dialog()
    desk.plan_export()
    settle(desk, ticks)
    target = take_path.with_name("out.c3d")
    perform(desk, "export_write", None, {"target": str(target)})
    settle(desk, ticks)
    assert "does not lie in the archive" in desk.message
    assert not target.exists()
    perform(desk, "export_write", None, {"target": "out.c3d"})
    settle(desk, ticks)
    assert (opened.take.source.path.parent / "out.c3d").exists()


def test_a_dropped_file_goes_into_the_archive_and_has_a_bound(lab_desk: tuple[Desk, Ticks]):
    desk, _ = lab_desk
    kept = desk.workspace.keep("../../new.c3d", b"12")
    assert kept.is_relative_to(desk.workspace.reach.root)
    desk.receive("large.c3d", bytes(1001))
    assert desk.message == (
        "large.c3d has 0.001 MB, and at most 0.001 MB can be dropped; let it be copied into the "
        "archive."
    )


def test_decisions_are_kept_under_the_name_of_the_login(lab_desk: tuple[Desk, Ticks]):
    desk, _ = lab_desk
    perform(desk, "reject")
    (record,) = desk.workspace.store.reviews()
    assert record.operator == "anna"
    assert {entry.operator for entry in desk.workspace.store.entries(record.id)} == {"anna"}


def test_an_operator_does_not_adjudicate(lab_desk: tuple[Desk, Ticks]):
    desk, _ = lab_desk
    assert {"adjudicate", "agreement"} <= set(NEEDS)
    for name in NEEDS:
        desk.dismiss()
        perform(desk, name, "0")
        assert "is for reviewers" in desk.message or desk.dialog, name


# origins


@pytest.mark.parametrize(
    ("given", "plain"),
    [
        ("https://Lab.Example", "https://lab.example"),
        ("https://lab.example:443/", "https://lab.example"),
        ("http://lab:80", "http://lab"),
        ("http://[::1]:5006", "http://[::1]:5006"),
    ],
)
def test_an_origin_is_written_as_browsers_do(given: str, plain: str):
    assert plain_origin(given) == plain


@pytest.mark.parametrize(
    "given", ["*", "lab", "lab:5006", "ftp://lab", "https://a@lab", "https://*.lab", "http://lab/x",
              "https://", "http://lab:notaport", "null", "http://lab?x", "http://la b"]
)  # fmt: skip
def test_what_is_no_origin_is_refused(given: str):
    with pytest.raises(BadInput, match="is no origin"):
        plain_origin(given)


def test_only_pages_of_the_server_are_admitted():
    own = loopback_doors(5006)
    assert own.admits("http://localhost:5006")
    for origin in ("http://localhost:5007", "https://localhost:5006", "http://evil.example", "null",
                   "", "http://localhost:5006.evil.example", "file://"):  # fmt: skip
        assert not own.admits(origin)
    assert Doors(("https://lab.example",)).https
    assert not own.https


def test_hosts_are_matched_whole():
    import re

    own = Doors(("https://lab.example", "http://[::1]:5006"))
    foreign = re.compile(own.foreign_host)
    for host in ("lab.example", "[::1]"):
        assert not foreign.match(host)
    for host in ("evil.example", "lab.example.evil.example", "xlab.example", "labxexample", ""):
        assert foreign.match(host)


def test_everywhere_needs_an_origin():
    with pytest.raises(BadInput, match="--origin"):
        doors("0.0.0.0", 5006, ())
    assert doors("10.0.0.7", 5006, ()).origins == ("http://10.0.0.7:5006",)
    assert doors("127.0.0.1", 5006, ["https://lab.example"]).origins == ("https://lab.example",)
    assert is_loopback("::1")
    assert not is_loopback("0.0.0.0")


# people


def test_passwords_are_kept_hashed_and_compared_whole():
    kept = hashed("correct horse")
    assert "correct" not in kept
    assert kept != hashed("correct horse"), "everybody has a salt of his own"
    assert fits("correct horse", kept)
    assert not fits("correct hors", kept)
    assert not fits("", kept)
    assert fits("plain", "plain")
    assert not fits("\ud800", "plain")


def test_people_are_read_again_when_the_file_changes(tmp_path: Path):
    path = tmp_path / "people.json"
    path.write_text(json.dumps({"anna": {"password": "one-password", "role": "teacher"}}))
    people = People(path, passwords=True)
    assert people.check("anna", "one-password") == Person("anna", "teacher", signed_in=True)
    assert people.check("anna", "two") is None
    assert people.check("bert", "one-password") is None
    assert people.in_plain_text == ("anna",)
    path.write_text(json.dumps({"bert": {"password": "another", "role": "operator"}}))
    assert people.person("anna") is None
    assert people.person("bert") is not None
    path.write_text("{")
    assert people.person("bert") is not None, "a file that is being written locks nobody out"


@pytest.mark.parametrize(
    "text",
    ["", "{}", "[]", '{"anna": 3}', '{"anna": {"role": "king", "password": "x"}}', '{"anna": ""}',
     '{"": "x"}', '{"a\\nb": "x"}', '{"anna": {"password": "scrypt$x"}}'],
)  # fmt: skip
def test_a_file_without_people_is_refused(tmp_path: Path, text: str):
    path = tmp_path / "people.json"
    path.write_text(text)
    with pytest.raises(BadInput):
        People(path, passwords=True)


def test_guessing_becomes_slow_for_one_name_and_not_for_others():
    tries = Tries()
    for _ in range(Tries.MOST):
        assert not tries.exhausted(("anna", "10.0.0.1"))
        tries.failed(("anna", "10.0.0.1"))
    assert tries.exhausted(("anna", "10.0.0.1"))
    assert not tries.exhausted(("bert", "10.0.0.1"))
    assert not tries.exhausted(("anna", "10.0.0.2"))


# headers


def transformed(guard: type[Guarded], content: str, body: bytes) -> tuple[HTTPHeaders, bytes]:
    headers = HTTPHeaders(
        {"Content-Type": content, "Content-Length": str(len(body)), "Server": "x"}
    )
    _, headers, body = guard(None).transform_first_chunk(200, headers, body, finishing=True)  # type: ignore[arg-type]
    return headers, body


def test_scripts_of_a_page_run_by_a_number_used_once():
    page = b"<html><script>one()</script><script src=x></script><scripted></html>"
    headers, body = transformed(Guarded, "text/html", page)
    again, _ = transformed(Guarded, "text/html", page)
    policy = headers["Content-Security-Policy"]
    assert "unsafe-eval" not in policy
    assert "'unsafe-inline'" not in policy.partition("style-src")[0]
    nonce = policy.partition("'nonce-")[2].partition("'")[0]
    assert body.count(f'<script nonce="{nonce}"'.encode()) == 2
    assert int(headers["Content-Length"]) == len(body)
    assert policy != again["Content-Security-Policy"]
    assert headers["Cache-Control"] == "no-store"
    assert "Server" not in headers
    assert "Strict-Transport-Security" not in headers
    assert "Strict-Transport-Security" in transformed(GuardedByTls, "text/html", page)[0]
    assert "Cache-Control" not in transformed(Guarded, "text/css", b"")[0]


# commands


@pytest.mark.parametrize(
    ("words", "said"),
    [
        ("--address 0.0.0.0", "anybody could decide on your takes"),
        ("--address 0.0.0.0 --login basic:{people}", "--origin"),
        ("--origin https://lab.example", "needs a --login"),
        ("--login basic:{people} --origin *", "is no origin"),
        ("--login magic:x", "basic:FILE or oauth:PROVIDER"),
        ("--login basic:nowhere.json", "cannot be read"),
        ("--login oauth:nobody --people {people}", "There is no provider"),
        ("--login oauth:github --people {people}", "PANEL_OAUTH_KEY"),
        ("--people {people}", "belongs to --login oauth"),
        ("--port 65535 --processes 2", "no ports above"),
        ("--max-upload 0", "positive number of MB"),
        ("--store postgresql://me:topsecret@127.0.0.1:1/x", "The store"),
    ],
)
def test_what_cannot_be_served_is_refused_before_it_is(
    archive: Path, tmp_path: Path, command: Command, words: str, said: str,
    monkeypatch: pytest.MonkeyPatch,
):  # fmt: skip
    for name in ("PANEL_OAUTH_KEY", "PANEL_OAUTH_SECRET"):
        monkeypatch.delenv(name, raising=False)
    people = tmp_path / "people.json"
    people.write_text(json.dumps({"anna": {"password": hashed("x")}}))
    store = [] if "--store" in words else ["--store", tmp_path / "s.sqlite"]
    ended = command("serve", archive, *words.format(people=people).split(), *store)
    assert said in ended.refusal
    assert "topsecret" not in ended.err


def test_a_folder_that_is_none_is_refused(tmp_path: Path, command: Command):
    assert "There is no folder" in command("serve", tmp_path / "nowhere").refusal


def test_accounts_are_written_for_the_owner_alone(
    tmp_path: Path, command: Command, monkeypatch: pytest.MonkeyPatch
):
    import io

    path = tmp_path / "people.json"

    def account(*words: str, password: str = "correct horse") -> object:
        monkeypatch.setattr(sys, "stdin", io.StringIO(password + "\n"))
        return command("account", path, *words)

    assert account("anna", "--role", "reviewer").code == 0
    assert account("bert").code == 0
    assert "correct" not in path.read_text()
    if os.name == "posix":
        assert path.stat().st_mode & 0o077 == 0
    people = People(path, passwords=True)
    assert people.check("anna", "correct horse").role == "reviewer"
    assert people.check("bert", "correct horse").role == "operator"
    assert "8 characters" in account("carl", password="short").refusal
    assert "has the role" in account("carl", "--role", "king").refusal
    assert account("anna", "--remove").code == 0
    assert people.person("anna") is None
    assert "last account" in account("bert", "--remove").refusal
