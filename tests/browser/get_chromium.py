"""Get a Chromium for the browser tests, where there is none."""

import os
import shutil
import subprocess
import sys

from playwright.sync_api import sync_playwright

from conftest import find_chromium

PACKAGES = ("chromium", "libegl1", "libgl1-mesa-dri")


def main() -> int:
    """Do nothing where a Chromium is found; else install one by apt as root, or Playwright's."""
    with sync_playwright() as playwright:
        if find_chromium(playwright) is not None:
            return 0
    apt = shutil.which("apt-get")
    if apt and os.geteuid() == 0:
        environment = {**os.environ, "DEBIAN_FRONTEND": "noninteractive"}
        subprocess.run([apt, "update", "-qq"], check=True, env=environment)
        return subprocess.run(
            [apt, "install", "-y", "-qq", *PACKAGES], check=False, env=environment
        ).returncode
    if apt:
        print(f"Install a browser first: sudo apt-get install {' '.join(PACKAGES)}")
        return 1
    return subprocess.run(
        [sys.executable, "-m", "playwright", "install", "chromium"], check=False
    ).returncode


if __name__ == "__main__":
    sys.exit(main())
