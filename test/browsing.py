"""A page in a real browser, and a report there."""


class Page:
    """A page in a browser, with what it complained of and asked for."""

    def __init__(self, browser, address, width=1280, height=900, scheme="light", touch=False):
        self.context = browser.new_context(
            viewport={"width": width, "height": height}, color_scheme=scheme, has_touch=touch
        )
        # A machine may have other things to do.
        self.context.set_default_timeout(120_000)
        self.page = self.context.new_page()
        self.complaints, self.requests = [], []
        self.page.on("console", lambda message: self.complaints.append(message.text))
        self.page.on("pageerror", lambda error: self.complaints.append(str(error)))
        self.page.on("request", lambda request: self.requests.append(request.url))
        self.page.goto(address)
        self.page.wait_for_selector("html[data-ready]")


class Opened(Page):
    """A report."""

    def __init__(self, browser, path, **options):
        super().__init__(browser, path.as_uri(), **options)

    def reading(self, name):
        return self.page.inner_text(f'[data-reading="{name}"]')

    def ranges(self):
        """Return the spans of time that the plots show, each once."""
        return self.page.evaluate(
            "[...new Set([...document.querySelectorAll('.plot')]"
            ".map((p) => p.layout.xaxis.range.map((x) => x.toFixed(6)).join()))]"
        )

    def span(self):
        (only,) = self.ranges()
        return tuple(map(float, only.split(",")))

    def on_plot(self, name, x, y=0.5):
        """Return the place on the screen at shares of a plot's width and height."""
        plot = self.page.locator(f'.plot[data-panel="{name}"]')
        plot.scroll_into_view_if_needed()
        box = plot.locator(".nsewdrag").first.bounding_box()
        return box["x"] + x * box["width"], box["y"] + y * box["height"]

    def hold(self):
        """Hold it to have complained of nothing, and to have asked nobody for anything."""
        assert self.complaints == []
        assert all(url.startswith(("file:", "data:", "blob:")) for url in self.requests)
