"""The site of the documentation: needs no network, and shows every formula, as Git hosts do."""

from __future__ import annotations

import html
import re
import subprocess
import sys
from html.parser import HTMLParser

import pytest
from browser import complaints, look_like, wait_for
from markdown_it import MarkdownIt
from pages import PAGES, ROOT

CODE = re.compile(r"^```.*?^```$|`[^`\n]*`", re.DOTALL | re.MULTILINE)
# Hosts want the dollars on lines of their own, and blank lines around them but none between.
DISPLAYED = re.compile(r"(?<=\n\n)\$\$\n((?:(?!\$\$).+\n)+)\$\$(?=\n\n|\n?\Z)")
INLINE = re.compile(r"(\S?)\$([^$\n]+)\$(\S?)")
# What may touch a dollar from outside; hosts take it for no formula beside a letter or a hyphen.
BEFORE, AFTER = ("", "("), ("", *".,;:)")
# Elements that load what they name, and the attribute.
LOADING = {"script": "src", "img": "src", "link": "href", "iframe": "src", "source": "src"}
LOADED_LINKS = ("stylesheet", "icon", "shortcut icon", "preload", "modulepreload", "manifest")
DRAWN = "return !!(window.MathJax && MathJax.startup && MathJax.startup.promise)"


def split(text):
    """Displayed and inline formulas, the latter with what touches them, and the rest of a page."""
    prose = CODE.sub("`code`", text)
    rest = DISPLAYED.sub("", prose)
    return DISPLAYED.findall(prose), INLINE.findall(rest), INLINE.sub("", rest)


def even(text):
    return " ".join(text.split())


def faults_on_hosts(text):
    """Formulas that a host without a grammar of formulas changes, by CommonMark and tables."""
    page = MarkdownIt("commonmark").enable(["table", "strikethrough"]).render(text)
    shown = even(html.unescape(re.sub(r"<[^>]*>", "", page)))
    displayed, inline, rest = split(text)
    found = [f for f in displayed if f"$$ {even(f)} $$" not in shown]
    found += [f for _, f, _ in inline if f"${f}$" not in shown or f != f.strip()]
    found += [a + f + b for a, f, b in inline if a not in BEFORE or b not in AFTER]
    return found + re.findall(r".*\$.*", rest)


WITH_FORMULAS = [p for p in PAGES if split(p.read_text(encoding="utf-8"))[0]]


@pytest.mark.parametrize("page", PAGES, ids=lambda p: p.name)
def test_git_hosts_show_the_formulas_as_they_are_written(page):
    """Hosts read a page as Markdown first: `_`, `*`, `|`, `<` or `\\,` may be gone by then."""
    assert not faults_on_hosts(page.read_text(encoding="utf-8"))


@pytest.mark.parametrize(
    "formula",
    [
        r"$\{a\}$",
        r"$a\,b$",
        r"$(a)_i + {b}_j$ and ${c}_{k}$",
        "$a*b*c$",
        "$a$-th",
        "x$a$",
        "$a",
        "$ a$",
        "| |\n|---|\n| $|a|$ |",
        "$a <b> c$",
        "$$\na \\\\\nb\n$$",
        "$$\na\n- b\n$$",
        "$$\na\n\nb\n$$",
        "$$a$$",
    ],
)
def test_a_formula_that_hosts_would_change_is_found(formula):
    assert faults_on_hosts(f"Text\n\n{formula}\n\ntext\n")


def build(pages, folder, *options):
    """Build a site; `pages` are patterns of what belongs to it."""
    command = [sys.executable, "-m", "sphinx", "-q", "-c", "docs", *options]
    if pages:
        command += ["-D", f"root_doc={pages[0].removesuffix('.md')}"]
        command += ["-D", f"include_patterns={','.join(pages)}"]
    done = subprocess.run(
        [*command, ".", folder], cwd=ROOT, capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr
    return folder


@pytest.fixture(scope="module")
def site(tmp_path_factory):
    """The pages with displayed formulas alone, in a second or two."""
    pages = [str(page.relative_to(ROOT)) for page in WITH_FORMULAS]
    return build(pages, tmp_path_factory.mktemp("site"))


@pytest.fixture(scope="module")
def whole_site(tmp_path_factory):
    return build([], tmp_path_factory.mktemp("whole_site"), "-W", "--keep-going")


class Loads(HTMLParser):
    """Addresses of what a page loads, and the classes of its elements."""

    def __init__(self, page):
        super().__init__()
        self.addresses, self.classes = [], []
        self.feed(page.read_text(encoding="utf-8"))

    def handle_starttag(self, tag, attrs):
        given = dict(attrs)
        self.classes.append((tag, (given.get("class") or "").split()))
        leads_on = tag == "link" and given.get("rel") not in LOADED_LINKS
        if tag in LOADING and given.get(LOADING[tag]) and not leads_on:
            self.addresses.append(given[LOADING[tag]])


def check_needs_no_network(folder):
    for page in folder.rglob("*.html"):
        for address in Loads(page).addresses:
            assert not re.match(r"\w+:(?!image/)|//", address), f"{page.name}: {address}"
            assert (page.parent / re.sub(r"[?#].*", "", address)).is_file(), (page.name, address)
    for sheet in folder.rglob("*.css"):
        text = sheet.read_text(encoding="utf-8")
        named = re.findall(r"url\(\s*[\"']?([^\"')]+)|@import\s+[\"']([^\"']+)", text)
        wanted = [first or second for first, second in named]
        assert not [x for x in wanted if re.match(r"(?!data:)\w+:|//", x)], sheet.name


def test_pages_with_formulas_load_nothing_from_the_network(site):
    check_needs_no_network(site)
    addresses = Loads(site / "docs" / "theory.html").addresses
    assert any("tex-svg.js" in address for address in addresses)
    assert sum(".css" in address for address in addresses) > 2


def test_every_displayed_formula_becomes_one(site):
    count = {}
    for page in WITH_FORMULAS:
        built = Loads(site / page.relative_to(ROOT).with_suffix(".html"))
        count[page.name] = sum(t == "div" and "math" in c for t, c in built.classes)
        text = page.read_text(encoding="utf-8")
        assert count[page.name] == len(split(text)[0]) == text.count("\n$$\n") / 2, page.name
    assert count["theory.md"] > 20


@pytest.mark.parametrize(
    "page",
    [
        pytest.param(p, id=p.name, marks=[] if p.name == "theory.md" else [pytest.mark.verify])
        for p in WITH_FORMULAS
    ],
)
def test_browser_draws_the_formulas_from_files(site, driver, page):
    """None is refused by MathJax, and on a phone wide ones scroll by themselves."""
    look_like(driver, 390, 844)
    complaints(driver)
    driver.get((site / page.relative_to(ROOT).with_suffix(".html")).as_uri())
    wait_for(driver, DRAWN)
    driver.execute_async_script("MathJax.startup.promise.then(arguments[0])")
    drawn = driver.execute_script(
        """const all = (s) => [...document.querySelectorAll(s)];
        return {
            displayed: all("mjx-container[display] svg").length,
            inline: all("mjx-container:not([display]) svg").length,
            // errors, and names that MathJax does not know, which it writes in red
            wrong: all("mjx-merror, [data-mjx-error], [data-mml-node=merror], svg [fill=red]")
                .map((e) => e.closest("mjx-container").textContent),
            far: all("[src], link[href]").map((e) => e.src || e.href)
                .filter((x) => !/^(file|data):/.test(x)),
            width: document.documentElement.scrollWidth,
        };"""
    )
    displayed, inline, _ = split(page.read_text(encoding="utf-8"))
    assert drawn == {
        "displayed": len(displayed),
        "inline": len(inline),
        "wrong": [],
        "far": [],
        "width": 390,
    }
    assert not complaints(driver)


@pytest.mark.verify
def test_site_is_built_without_warnings(whole_site):
    assert (whole_site / "docs" / "tutorial.html").is_file()
    assert "docs/index.html" in (whole_site / "index.html").read_text()


@pytest.mark.verify
def test_whole_site_loads_nothing_from_the_network(whole_site):
    check_needs_no_network(whole_site)
