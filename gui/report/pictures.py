"""The images of a report as they stand on paper."""

from __future__ import annotations

from PySide6.QtCore import QByteArray, QPointF, QRectF, Qt
from PySide6.QtGui import QColor, QFont, QImage, QPainter, QPen
from PySide6.QtSvg import QSvgRenderer

from gui.report.pages import points
from ilf.report.content import ColourBar, Image, Legend, Picture, Plot, ScaleBar

_MARK_PT = 6.5
_INK = QColor("#1c2126")


def image_of(image: Image) -> QImage:
    """A decoded image."""
    found = QImage()
    found.loadFromData(image.data)
    return found.convertToFormat(QImage.Format.Format_RGB32)


def picture_image(picture: Picture, width: int) -> QImage:
    """A picture, so many dots wide if it has marks, which are written on it."""
    image = image_of(picture.image)
    if not picture.marks:
        return image
    image = image.scaledToWidth(width, Qt.TransformationMode.SmoothTransformation)
    painter = QPainter(image)
    painter.setRenderHint(QPainter.RenderHint.Antialiasing)
    font = QFont()
    font.setPixelSize(round(points(_MARK_PT)))
    font.setBold(True)
    painter.setFont(font)
    metrics = painter.fontMetrics()
    for mark in picture.marks:
        plate = QRectF(0, 0, metrics.horizontalAdvance(mark.text) + 8, metrics.height() - 4)
        plate.moveCenter(QPointF(mark.x * image.width(), mark.y * image.height()))
        painter.setPen(Qt.PenStyle.NoPen)
        painter.setBrush(QColor(0, 0, 0, 150))
        painter.drawRoundedRect(plate, 6, 6)
        painter.setPen(QColor("white"))
        painter.drawText(plate, Qt.AlignmentFlag.AlignCenter, mark.text)
    painter.end()
    return image


def bar_image(bar: ColourBar, width: int) -> QImage:
    """A colour bar under a picture that is so many dots wide."""
    gap, height = round(points(3)), round(points(6))
    image = QImage(width, gap + height, QImage.Format.Format_RGB32)
    image.fill(QColor("white"))
    painter = QPainter(image)
    painter.drawImage(QRectF(0, gap, width, height), image_of(bar.image))
    painter.end()
    return image


def scale_image(scale: ScaleBar, width: int) -> QImage:
    """A scale bar under a picture that is so many dots wide."""
    gap, height = points(3), round(points(7))
    image = QImage(max(round(scale.share * width), 4), height, QImage.Format.Format_RGB32)
    image.fill(QColor("white"))
    painter = QPainter(image)
    painter.setPen(QPen(_INK, points(0.9)))
    right, low = image.width() - 2.0, height - 2.0
    painter.drawPolyline([QPointF(2, gap), QPointF(2, low), QPointF(right, low), QPointF(right, gap)])
    painter.end()
    return image


def plate_image(colour: tuple[int, int, int]) -> QImage:
    """A small plate of a colour."""
    side = round(points(6))
    image = QImage(side, side, QImage.Format.Format_RGB32)
    image.fill(QColor(*colour))
    return image


def line_image(item: Legend) -> QImage:
    """A short line as it stands for a curve."""
    width, height = round(points(20)), round(points(6))
    image = QImage(width, height, QImage.Format.Format_RGB32)
    image.fill(QColor("white"))
    painter = QPainter(image)
    pen = QPen(QColor(*item.colour), points(1.6))
    if item.dashes:
        pen.setDashPattern([float(length) / 2 for length in item.dashes.split()])
        pen.setCapStyle(Qt.PenCapStyle.FlatCap)
    painter.setPen(pen)
    painter.drawLine(QPointF(0, height / 2), QPointF(width, height / 2))
    painter.end()
    return image


def plot_image(plot: Plot, width: int) -> QImage:
    """Curves, so many dots wide."""
    image = QImage(width, round(width * plot.size[1] / plot.size[0]), QImage.Format.Format_RGB32)
    image.fill(QColor("white"))
    painter = QPainter(image)
    painter.setRenderHint(QPainter.RenderHint.Antialiasing)
    QSvgRenderer(QByteArray(plot.svg.encode())).render(painter, QRectF(image.rect()))
    painter.end()
    return image
