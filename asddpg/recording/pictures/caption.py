"""A line of text on a picture."""

from collections.abc import Mapping

from PIL import Image, ImageDraw, ImageFont

_SHADE = (20, 22, 26, 170)
_WHITE = (255, 255, 255, 255)
Colour = tuple[float, float, float]  # each from 0 to 1

OUTCOME_COLOURS: Mapping[str, Colour] = {
    "reached": (0.0, 0.62, 0.45),
    "crashed": (0.84, 0.22, 0.16),
    "timeout": (0.95, 0.9, 0.25),
}


def captioned(image: Image.Image, text: str, colour: Colour | None = None, above: bool = False) -> Image.Image:
    """The picture with a line of text on a dark strip along its top, behind a dot of a colour if one is given.

    The strip lies upon the picture, or `above` it, where it hides nothing and the picture grows.
    """
    size = max(9, image.height // 22)
    font = ImageFont.load_default(size)
    strip = Image.new("RGBA", (image.width, 2 * size), _SHADE)
    draw = ImageDraw.Draw(strip)
    left = size // 2
    if colour is not None:
        draw.ellipse((left, size // 2, left + size, size // 2 + size), fill=_bytes(colour), outline=_WHITE)
        left += size + size // 2
    draw.text((left, size), text, font=font, fill=_WHITE, anchor="lm")
    top = strip.height if above else 0
    whole = Image.new("RGBA", (image.width, image.height + top), "white")
    whole.paste(image, (0, top))
    whole.alpha_composite(strip)
    return whole.convert("RGB")


def _bytes(colour: Colour) -> tuple[int, int, int, int]:
    red, green, blue = (round(255 * part) for part in colour)
    return red, green, blue, 255
