"""Figures for print: lines stay lines and letters letters, at one size on paper in every format."""

import re
import zlib
from xml.etree import ElementTree

import numpy as np
import pytest
from PySide6.QtCore import QPointF, QRectF, QSize, QSizeF, Qt
from PySide6.QtGui import QColor, QImage, QPainter
from PySide6.QtSvg import QSvgRenderer

from inspector.recording.choice import Contents, Paper, RecordChoice, Shot
from inspector.recording.page_layout import part_rectangles
from inspector.recording.sheet import Sheet, SheetPicture, SheetShape, Words
from inspector.recording.stage import WHITE, Shown, Stage
from inspector.teaching.equation_table import teaching_tab_formulas
from inspector.timeline.title_lines import title_lines
from inspector.widgets.theme import DARK, figures_font
from tests.gui.windows import act

ONE_WINDOW = True

EVERYTHING = Contents(equations=True)
WIDE_MM, DPI = 180.0, 300.0
SVG = "{http://www.w3.org/2000/svg}"


def pixels(mm, dpi=DPI):
    return round(mm / 25.4 * dpi)


PAGE = (pixels(WIDE_MM), 0)

pytestmark = pytest.mark.usefixtures("qapp")  # fonts need one


@pytest.fixture
def window(qtbot, at_forearm):
    """The teaching tab on, an interval selected and in view, its symbols typeset."""
    window = at_forearm
    act(window, "show_teaching")
    act(window, "next_interval")
    qtbot.waitUntil(lambda: window.teaching.typesetter.done, timeout=30_000)
    return window


@pytest.fixture
def figure(window, tmp_path):
    """Records the window's frame as a figure; its file."""

    def make(name, size=PAGE, contents=EVERYTHING, paper=None):
        paper = paper or Paper(DPI, 8.0, white=True)
        choice = RecordChoice(tmp_path / name, size=size, contents=contents, paper=paper)
        window.record_actions.record(choice)
        assert window.bar.label.text() == f"{name} was written."
        return choice.path

    return make


@pytest.fixture
def sheet(window, tmp_path):
    """The window's frame on a sheet, with the stage that it was painted from."""
    staged = []

    def make(contents=EVERYTHING, paper=None, size=PAGE):
        paper = paper or Paper(DPI, 8.0, white=True)
        taken = Shown(window.taught, window.viewport, window.timeline, window.teaching.typesetter)
        choice = RecordChoice(tmp_path / "x.svg", size=size, contents=contents, paper=paper)
        staged.append(Stage(taken, choice))
        staged[-1].show_shot(Shot(window.document.frame))
        return staged[-1].sheet()

    yield make
    for stage in staged:
        stage.close_views()


# -- figures --------------------------------------------------------------------------------------


def tau_lines(root):
    """The lines in the colour of τ that run across a plot."""
    for path in root.iter(f"{SVG}path"):
        if path.attrib.get("stroke") == WHITE.tau:
            numbers = [float(n) for n in re.findall(r"-?[\d.]+", path.attrib["d"])]
            if len(numbers) == 4 and abs(numbers[2] - numbers[0]) > 100.0:
                yield path, numbers


@pytest.mark.thorough
def test_svg_of_everything_needs_nothing_that_readers_pass_over(figure):
    text = figure("all.svg").read_bytes()
    for unknown in (b"vector-effect", b"transform", b"<text", b"<use", b"<style", b"clip-path"):
        assert unknown not in text
    root = ElementTree.fromstring(text)
    widths = [float(p.attrib["stroke-width"]) for p in root.iter() if "stroke-width" in p.attrib]
    assert len(widths) > 50
    assert max(widths) <= 6.0  # the halo round a label is the widest, five units
    ((line, (_, y0, _, y1)),) = tau_lines(root)
    assert float(line.attrib["stroke-width"]) == 1.6
    assert "stroke-dasharray" not in line.attrib
    assert y0 == y1
    said = " ".join(p.attrib.get("aria-label", "") for p in root.iter())
    for words in ("Twist", "Strength", "frame", "Parent P", "(13)", "captured"):
        assert words in said
    assert root.attrib["width"] == "180mm" or float(root.attrib["width"][:-2]) == pytest.approx(
        180.0, abs=0.05
    )


@pytest.mark.thorough
def test_qt_draws_the_svg_as_the_png(figure):
    contents = Contents(view=False, equations=True)
    png = QImage(str(figure("same.png", contents=contents, paper=Paper(96.0, 8.0, white=True),
                            size=(680, 700))))  # fmt: skip
    svg = figure("same.svg", contents=contents, paper=Paper(96.0, 8.0, white=True), size=(680, 700))
    drawn = QImage(png.size(), QImage.Format.Format_RGB32)
    drawn.fill(QColor("white"))
    painter = QPainter(drawn)
    QSvgRenderer(str(svg)).render(painter)
    painter.end()
    a, b = (grey(image.scaled(QSize(170, 175), mode=Qt.TransformationMode.SmoothTransformation))
            for image in (png, drawn))  # fmt: skip
    assert a.std() > 15.0
    assert np.abs(a - b).mean() < 2.0
    assert np.corrcoef(a.ravel(), b.ravel())[0, 1] > 0.97


def grey(image):
    """Its brightness, (height, width)."""
    image = image.convertToFormat(QImage.Format.Format_Grayscale8)
    rows = np.frombuffer(image.constBits(), np.uint8).reshape(image.height(), -1)
    return rows[:, : image.width()].astype(float)


@pytest.mark.thorough
def test_no_edge_runs_through_the_numbers_of_an_axis(sheet):
    items = sheet(Contents(view=False)).items
    numbers = [
        w.outline().boundingRect()
        for w in items
        if isinstance(w, Words) and re.fullmatch(r"−?\d+°?", w.text.strip())
    ]
    assert len(numbers) > 8
    edges = [s for s in items if isinstance(s, SheetShape) and s.pen and s.pen.style() != 1]
    assert edges
    for edge in edges:
        box = edge.path.boundingRect().adjusted(-1.0, 0.0, 1.0, 0.0)
        if edge.clip is not None:
            box = box.intersected(edge.clip.boundingRect())
        assert not any(box.intersects(number) for number in numbers)


@pytest.mark.thorough
@pytest.mark.parametrize("wide", [90.0, 180.0])
def test_every_word_is_whole_and_on_the_paper(sheet, wide):
    paper = sheet(size=(pixels(wide), 0))
    for words in (item for item in paper.items if isinstance(item, Words)):
        box = words.outline().boundingRect()
        assert paper.box.contains(box), words.text
        assert "…" not in words.text
        assert words.clip is None or words.clip.boundingRect().contains(box), words.text
    titles = "".join(w.text for w in paper.items if isinstance(w, Words))
    for plot in ("Twist", "Perframe", "Strength", "Offset", "after"):
        assert plot in titles.replace(" ", "")


@pytest.mark.thorough
def test_the_view_is_drawn_at_the_resolution_of_print(sheet):
    fine, coarse = (
        [p for p in sheet(paper=Paper(dpi, 8.0, white=True), size=(pixels(90.0, dpi), 0)).items
         if isinstance(p, SheetPicture)]
        for dpi in (300.0, 96.0)
    )  # fmt: skip
    assert [p.image.width() for p in fine] == [pixels(90.0)]
    assert [p.image.width() for p in coarse] == [340]


@pytest.mark.thorough
def test_lines_of_the_view_are_as_thick_on_paper_at_any_resolution(sheet):
    """The teal arc of the swing covers the same share of the picture."""
    shares = []
    for dpi in (96.0, 384.0):
        (picture,) = (
            p for p in sheet(Contents(curves=False), Paper(dpi, 8.0, white=True),
                             (pixels(90.0, dpi), pixels(60.0, dpi))).items
            if isinstance(p, SheetPicture)
        )  # fmt: skip
        image = picture.image.convertToFormat(QImage.Format.Format_RGB888)
        rows = np.frombuffer(image.constBits(), np.uint8).reshape(image.height(), -1)
        rgb = rows[:, : 3 * image.width()].reshape(image.height(), image.width(), 3).astype(int)
        line = np.abs(rgb - [0xA3, 0x19, 0x5B]).max(axis=2) < 60  # the ring of the twist
        shares.append(line.mean())
    assert shares[0] > 1e-4
    assert shares[1] == pytest.approx(shares[0], rel=0.5)


@pytest.mark.thorough
def test_pdf_has_fonts_inside_lines_as_lines_and_one_picture(figure):
    data = figure("all.pdf", size=(pixels(90.0), 0)).read_bytes()
    assert data.startswith(b"%PDF-")
    fonts, files = data.count(b"/Type /FontDescriptor"), data.count(b"/FontFile")
    assert fonts == files > 1
    (box,) = set(re.findall(rb"/MediaBox \[([^\]]+)\]", data))
    assert float(box.split()[2]) == pytest.approx(90.0 / 25.4 * 72.0, abs=1.0)
    sizes = re.findall(rb"/Subtype /Image\s+/Width (\d+)\s+/Height (\d+)", data)
    assert [int(wide) for wide, _ in sizes] == [pixels(90.0)]
    streams = b"".join(inflated(data))
    assert len(re.findall(rb"\bl\n|\bS\n", streams)) > 100  # lines and strokes
    assert len(re.findall(rb"\bTj\b|\bTJ\b|> Tj", streams)) > 40  # letters


def inflated(data):
    """What the streams of a PDF say, those that can be unpacked."""
    for raw in re.findall(rb"stream\r?\n(.*?)endstream", data, re.DOTALL):
        try:
            yield zlib.decompress(raw)
        except zlib.error:
            continue


def height_of_letters(path):
    """Rows with ink of the tallest of the dark letters in the topmost line of a picture."""
    rows = (grey(QImage(str(path))) < 120.0).any(axis=1)
    start = int(np.argmax(rows))
    return int(np.argmin(rows[start:]))


@pytest.mark.thorough
def test_letters_have_one_size_on_paper_and_as_many_pixels_as_dpi_ask_for(figure):
    def letters(name, dpi, points):
        size = (pixels(90.0, dpi), pixels(60.0, dpi))
        path = figure(name, size, Contents(view=False), Paper(dpi, points, white=True))
        image = QImage(str(path))
        assert (image.width(), image.height()) == size
        assert image.dotsPerMeterX() == round(dpi / 0.0254)
        return height_of_letters(path)

    usual = letters("a.png", 300.0, 8.0)
    capital = 8.0 * 9.0 / 8.0 * 0.73 / 72.0 * 300.0  # of DejaVu at the readout's 9 points
    assert usual == pytest.approx(capital, rel=0.35)  # a slash reaches below the line
    assert letters("b.png", 600.0, 8.0) == pytest.approx(2.0 * usual, abs=2.0)
    assert letters("c.png", 300.0, 16.0) == pytest.approx(2.0 * usual, abs=2.0)


@pytest.mark.thorough
def test_white_paper_is_white_whatever_the_program_wears(window, figure):
    assert window.viewport.theme is DARK
    size = (pixels(90.0, 100.0), 0)
    image = QImage(str(figure("white.png", size, paper=Paper(100.0, 8.0, white=True))))
    assert np.mean(grey(image) > 250.0) > 0.6
    svg = figure("white.svg").read_text()
    for role in ("surface", "window", "text", "soft"):
        assert getattr(DARK, role) not in svg
    dark = QImage(str(figure("dark.png", size, paper=Paper(100.0, 8.0))))
    assert np.mean(grey(dark) < 60.0) > 0.6


def test_a_figure_shows_what_the_plots_show(window, sheet):
    window.timeline.visible.show(100.0, 140.0)
    window.timeline.toggles["delta"].setChecked(False)
    said = [w.text.strip() for w in sheet(Contents(view=False)).items if isinstance(w, Words)]
    frames = [int(t) for t in said if t.isdigit()]
    assert min(frames) >= 100
    assert max(frames) <= 140
    assert not any("Per" in t for t in said)


@pytest.mark.thorough
def test_a_long_title_goes_on_in_a_second_line_and_parts_no_name_from_its_number(window, sheet):
    window.taught.alter(twist=1.3, counter=True)
    items = sheet(size=(pixels(90.0), 0)).items
    words = {w.text.strip(): w.outline().boundingRect() for w in items if isinstance(w, Words)}
    angle = next(text for text in words if "○" in text)
    assert words["Twist"].bottom() < words[angle].top()
    title = [("Twist ", "soft"), ("θp", "text"), ("   1.0°", "before"), ("   ", "soft"),
             ("   what if m ● 2.0°", "after"), ("   n ○ 3.0°", "after")]  # fmt: skip
    told = ["".join(text for text, _ in line) for line in title_lines(title, 20.0, len)]
    assert told == ["Twist θp 1.0° ", "what if m ● 2.0°", "n ○ 3.0°"]
    assert len(title_lines(title, 50.0, len)) == 1


def test_type_alone_decides_what_a_size_holds():
    """Nothing overlaps, nothing leaves the page, whatever is shown."""
    wanted = QSizeF(380.0, 360.0)
    for wide, high in ((300.0, 900.0), (340.0, 400.0), (700.0, 500.0), (1280.0, 720.0)):
        for k in range(1, 8):
            contents = Contents(bool(k & 1), bool(k & 2), bool(k & 4))
            page = QRectF(0.0, 0.0, wide, high)
            found = part_rectangles(page.size(), contents, wanted)
            assert len(found) == bin(k).count("1")
            for name, box in found.items():
                assert page.adjusted(0, 0, 0.01, 0.01).contains(box), (wide, high, k, name)
                assert box.width() > 50.0
                assert box.height() > 50.0
                others = [b for key, b in found.items() if key != name]
                assert not any(box.adjusted(0.5, 0.5, -0.5, -0.5).intersects(b) for b in others)


@pytest.mark.thorough
@pytest.mark.usefixtures("new_window")
def test_equations_are_typeset_first_where_the_tab_was_never_shown(qtbot, at_forearm, tmp_path):
    path = tmp_path / "first.svg"
    contents = Contents(view=False, curves=False, equations=True)
    at_forearm.record_actions.record(RecordChoice(path, size=(600, 0), contents=contents))
    assert not path.exists()
    qtbot.waitUntil(path.exists, timeout=30_000)
    assert not at_forearm.taught.active
    assert "atan2" not in path.read_text()  # TeX is outlines …
    assert path.read_text().count("<path") > 60


@pytest.mark.thorough
def test_equations_are_typeset_first_where_a_lesson_has_set_its_own(qtbot, at_forearm, tmp_path):
    typesetter = at_forearm.teaching.typesetter
    typesetter.start(["x^2"])
    qtbot.waitUntil(lambda: typesetter.done, timeout=30_000)
    path = tmp_path / "first.svg"
    contents = Contents(view=False, curves=False, equations=True)
    at_forearm.record_actions.record(RecordChoice(path, size=(600, 0), contents=contents))
    qtbot.waitUntil(path.exists, timeout=30_000)
    assert typesetter.has(teaching_tab_formulas())
    assert path.read_text().count("<path") > 60


def test_letters_are_set_alike_wherever_they_are_put_down(qapp):
    """In the font they were painted in, though that is the program's and it has another now."""
    sheet = Sheet(300.0, 60.0, 96)
    painter = QPainter(sheet)
    painter.drawText(QPointF(5.0, 30.0), "0.981 iii")
    painter.end()
    (words,) = sheet.items
    image = QImage(1200, 240, QImage.Format.Format_RGB32)
    image.fill(QColor("white"))
    mine = qapp.font()
    qapp.setFont(figures_font(2.0 * mine.pointSizeF()))
    try:
        painter = QPainter(image)
        painter.scale(4.0, 4.0)
        sheet.paint(painter)
        painter.end()
        box = words.outline().boundingRect()
    finally:
        qapp.setFont(mine)
    columns = np.flatnonzero((grey(image) < 128.0).any(axis=0))
    assert columns[0] / 4.0 == pytest.approx(box.left(), abs=0.5)
    assert columns[-1] / 4.0 == pytest.approx(box.right(), abs=0.5)
