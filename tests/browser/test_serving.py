"""A lab's server in a real browser: log in, decide, log out; and what the content policy stops."""

import json
import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from tests.visitor import Served, free_ports

import markermend as mm
from markermend.review.store import Store
from markermend_app.serving.accounts import hashed

from .desk_page import OPENS_MS

PASSWORD = "correct horse battery"
LABEL = "<img src=x onerror=window.broken=1>"
INJECTED = """() => {
  window.refusals = [];
  addEventListener("securitypolicyviolation", (e) => refusals.push(e.effectiveDirective));
  const place = document.createElement("div");
  document.body.append(place);
  place.innerHTML = '<img src="data:," onerror="window.broken = 1">';
  const script = document.createElement("script");
  script.textContent = "window.broken = 2";
  document.body.append(script);
  // Later, since what a test itself evaluates is let through.
  setTimeout(() => {
    try { new Function("window.broken = 3")(); } catch { /* as it should be */ }
  });
  new Image().src = "http://127.0.0.1:9/leak";
}"""


@pytest.fixture
def lab(tmp_path: Path) -> Iterator[Served]:
    archive, people = tmp_path / "archive", tmp_path / "people.json"
    archive.mkdir()
    t = np.arange(400) / 100
    swing = np.column_stack([300 * np.sin(2 * t), 100 * np.cos(3 * t), 900 + 40 * np.sin(4 * t)])
    offsets = np.random.default_rng(4).normal(0, 90, (6, 3))
    positions = swing[:, None] + offsets
    positions[100:130, 2] = np.nan
    positions[250:270, 4] = np.nan
    labels = ["A", "B", LABEL, "D", "E", "F"]
    mm.write(mm.Take(positions, 100, labels), archive / "walk.npz")
    people.write_text(json.dumps({"anna": {"password": hashed(PASSWORD), "role": "reviewer"}}))
    served = Served(
        "serve", archive, "--store", tmp_path / "store.sqlite", "--port", free_ports(),
        "--login", f"basic:{people}", log=tmp_path / "log.txt",
    )  # fmt: skip
    yield served
    served.stop()


def test_log_in_decide_and_log_out(lab: Served, open_page: Any, tmp_path: Path):
    page = open_page(lab.url)
    page.get_by_label("Name").fill("anna")
    page.get_by_label("Password").fill(PASSWORD)
    page.get_by_role("button", name="Log in").click()
    page.wait_for_selector(".row", timeout=OPENS_MS)
    page.get_by_text("walk.npz").first.wait_for()
    page.keyboard.press("f")
    page.wait_for_function(
        """() => {
          const find = (node) => [...node.querySelectorAll("*")].some((child) =>
            /^1 of 2 settled/.test(child.textContent.trim()) ||
            (child.shadowRoot && find(child.shadowRoot)));
          return find(document);
        }""",
        timeout=OPENS_MS,
    )
    assert page.evaluate("window.broken") is None, "a label of a take is text"
    with Store(tmp_path / "store.sqlite") as store:
        (record,) = store.reviews()
        assert (record.operator, len(store.entries(record.id))) == ("anna", 1)

    page.get_by_role("link", name="Log out").click()
    page.get_by_text("You are logged out").wait_for()
    page.goto(lab.url)
    page.get_by_label("Password").wait_for()


def test_what_is_injected_into_the_page_does_not_run(lab: Served, browser: Any):
    page = browser.new_page()
    page.goto(lab.url)
    page.get_by_label("Name").fill("anna")
    page.get_by_label("Password").fill(PASSWORD)
    page.get_by_role("button", name="Log in").click()
    page.wait_for_selector(".row", timeout=OPENS_MS)
    page.evaluate(INJECTED)
    page.wait_for_function("() => refusals.length >= 4")
    assert page.evaluate("window.broken ?? 'whole'") == "whole"
    refused = {re.sub("-(attr|elem)$", "", name) for name in page.evaluate("refusals")}
    assert refused == {"script-src", "img-src"}
    page.close()
