"""What tests in a browser share: Chromium without network, its console, axe-core."""
import pathlib
import shutil
import sys
import time

AXE = pathlib.Path(__file__).resolve().parents[1] / ".cache/axe/axe.min.js"  # scripts/setup --dev fetches it
SWITCHES = ["--headless", "--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run", "--disable-background-networking",
            "--disable-component-update", "--disable-sync", "--use-angle=swiftshader", "--enable-unsafe-swiftshader",
            "--window-size=1300,1000", "--host-resolver-rules=MAP * ~NOTFOUND, EXCLUDE 127.0.0.1"]  # the last: there is no network


def skip_without_browser():
    """Ends with 77, and says why, where no browser can be driven."""
    reason = ""
    for name, package in [("chromium", "chromium"), ("chromedriver", "chromium-driver")]:
        if not shutil.which(name):
            reason = f"the program {name} (Debian package {package})"
    try:
        import selenium  # noqa: F401
    except ImportError:
        reason = "the Python module selenium (Debian package python3-selenium)"
    if reason:
        print(f"skipped: no browser can be driven: {reason} is missing")
        sys.exit(77)


def check(true, what, *shown):
    if true:
        return
    for one in shown:
        print(one, file=sys.stderr)
    sys.exit(f"FAILED: {what}")


class Browser:
    def __init__(self, profile):
        from selenium import webdriver
        options = webdriver.ChromeOptions()
        for switch in [*SWITCHES, f"--user-data-dir={profile}"]:
            options.add_argument(switch)
        options.binary_location = shutil.which("chromium")
        options.set_capability("goog:loggingPrefs", {"browser": "ALL"})
        service = webdriver.chrome.service.Service(shutil.which("chromedriver"))
        self.driver = webdriver.Chrome(service=service, options=options)

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.driver.quit()

    def open(self, page):
        self.driver.get(page.as_uri())

    def js(self, script, *arguments):
        return self.driver.execute_script(script, *arguments)

    def wait(self, what, script, limit_s=60):
        end = time.monotonic() + limit_s
        while not self.js(f"return {script}"):
            check(time.monotonic() < end, f"{what} within {limit_s} s", self.js("return document.body.innerText"))
            time.sleep(0.05)

    def console_errors(self):
        # A driver that draws in software reports its speed; that is no error of the page.
        return [one for one in self.driver.get_log("browser") if "GL Driver Message" not in one["message"]]

    def check_console(self):
        errors = self.console_errors()
        check(not errors, "nothing in the console", *errors)

    def axe(self, tags):
        """WCAG by axe-core: how many texts' contrast was measured, and what is wrong."""
        self.js(AXE.read_text())
        self.driver.set_script_timeout(120)
        return self.driver.execute_async_script("""
          const done = arguments[arguments.length - 1];
          axe.run(document, {runOnly: arguments[0]}).then(r => done({
            measured: r.passes.filter(p => p.id === 'color-contrast').reduce((n, p) => n + p.nodes.length, 0),
            wrong: r.violations.map(v => [v.id, v.nodes.length, v.nodes[0].html, v.nodes[0].failureSummary])}));""", tags)
