"""From radiance to the colour picture: exposure, white balance, and what camera and storage do to it."""

from __future__ import annotations

import cv2
import numpy as np


def developed(radiance: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    """Linear radiance (H, W, 3) as 8-bit RGB with the faults of cheap cameras, drawn at random."""
    height, width = radiance.shape[:2]
    if rng.random() < 0.5:
        radiance = _glowing(radiance, float(rng.uniform(0.02, 0.3)), rng)
    light = radiance * (1 + rng.normal(0, 0.08, 3) * rng.choice([0.3, 1.0, 2.0])).clip(0.5, 1.6)
    if rng.random() < 0.4:
        light = light * _mixed_white(light.shape[:2], rng)
    grey = light.mean(axis=2)
    exposure = rng.choice([0.12, 0.22, 0.35, 0.5, 0.8]) / max(float(np.sqrt(np.mean(grey) * np.median(grey))), 1e-4)
    light = light * exposure * float(np.exp(rng.normal(0, 0.3)))
    rows, columns = np.mgrid[:height, :width].astype(np.float32)
    off = np.hypot(columns - width / 2, rows - height / 2) / np.hypot(width / 2, height / 2)
    light = light * (1 - float(rng.uniform(0, 0.5)) * rng.choice([0.3, 1.0]) * off**2)[..., None]
    light = _moved(light.astype(np.float32), rng)
    light = _blurred(light, rng)
    noise = float(np.exp(rng.uniform(np.log(0.001), np.log(0.03))))
    light = light + noise * np.sqrt(np.clip(light, 0.01, 2)) * _grain(light.shape, rng)
    picture = _toned(light, rng)
    if rng.random() < 0.4:
        picture = picture + float(rng.uniform(0.2, 1.2)) * (picture - cv2.GaussianBlur(picture, (0, 0), 1.2))
    if rng.random() < 0.06:
        picture = np.repeat(picture.mean(axis=2, keepdims=True), 3, axis=2)
    eight = np.clip(np.round(picture * 255), 0, 255).astype(np.uint8)
    if rng.random() < 0.1:
        _frame(eight, rng)
    if rng.random() < 0.65:
        quality = int(rng.integers(35, 97))
        _, packed = cv2.imencode(".jpg", eight[..., ::-1], [cv2.IMWRITE_JPEG_QUALITY, quality])
        eight = cv2.imdecode(packed, cv2.IMREAD_COLOR)[..., ::-1]
    return np.ascontiguousarray(eight)


def _frame(picture: np.ndarray, rng: np.random.Generator) -> None:
    """White or black strips along the sides, as cameras leave whose pictures were straightened."""
    height, width = picture.shape[:2]
    left, right, top, bottom = (rng.uniform(0, 0.03, 4) * (width, width, height, height)).astype(int)
    tone = rng.choice([0, 255], p=[0.3, 0.7])
    for strip in (picture[:, :left], picture[:, width - right :], picture[:top], picture[height - bottom :]):
        strip[:] = tone


def _mixed_white(shape: tuple[int, ...], rng: np.random.Generator) -> np.ndarray:
    """Gains (H, W, 3) that change from warm to cold across the picture, as between a lamp and a window."""
    height, width = shape
    turn, reach = rng.uniform(0, 2 * np.pi), rng.uniform(0.05, 0.35)
    x, y = np.linspace(-1, 1, width, dtype=np.float32), np.linspace(-1, 1, height, dtype=np.float32)[:, None]
    warmth = np.tanh(rng.uniform(0.6, 2.5) * (x * np.cos(turn) + y * np.sin(turn) + rng.uniform(-0.5, 0.5)))
    return np.exp(reach * warmth[..., None] * np.array([1, 0.1, -1], np.float32)).astype(np.float32)


def _moved(light: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    """Colour and depth of real cameras fit only to about a pixel."""
    x, y = np.clip(rng.normal(0, rng.choice([0.0, 0.4, 1.0], p=[0.4, 0.4, 0.2]), 2), -2, 2)
    matrix = np.array([[1, 0, x], [0, 1, y]])
    return cv2.warpAffine(light, matrix, light.shape[1::-1], flags=cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)


def _blurred(light: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    kind = rng.random()
    if kind < 0.45:
        return cv2.GaussianBlur(light, (0, 0), float(rng.uniform(0.3, 1.1)))
    if kind < 0.52:
        return cv2.GaussianBlur(light, (0, 0), float(rng.uniform(1.1, 2.2)))
    if kind < 0.64:
        length, turn = int(rng.integers(3, 8)), rng.uniform(0, np.pi)
        kernel = np.zeros((9, 9), np.float32)
        for t in np.linspace(-length / 2, length / 2, 40):
            kernel[round(4 + t * np.sin(turn)), round(4 + t * np.cos(turn))] += 1
        return cv2.filter2D(light, -1, kernel / kernel.sum())
    return light


def _grain(shape: tuple[int, ...], rng: np.random.Generator) -> np.ndarray:
    """Noise, at times smeared by the demosaicing and with less of it in colour."""
    noise = rng.standard_normal(shape, dtype=np.float32)
    if rng.random() < 0.5:
        noise = 1.8 * cv2.GaussianBlur(noise, (0, 0), float(rng.uniform(0.5, 0.9)))
    share = float(rng.uniform(0, 1))
    noise = share * noise.mean(axis=2, keepdims=True) * 1.7 + (1 - share) * noise
    if rng.random() < 0.35:
        blotches = cv2.GaussianBlur(rng.standard_normal(shape, dtype=np.float32), (0, 0), 2.0)
        noise += float(rng.uniform(1, 5)) * (blotches - blotches.mean(axis=2, keepdims=True))
    return noise


def _toned(light: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    """sRGB with a soft shoulder at times, more or less contrast and colour, and a black level."""
    light = np.clip(light, 0, None)
    if rng.random() < 0.5:
        light = light / (1 + light) * 1.5
    light = np.clip(light, 0, 1)
    picture = np.where(light <= 0.0031308, 12.92 * light, 1.055 * light ** (1 / 2.4) - 0.055)
    picture = picture ** float(rng.uniform(0.8, 1.25))
    grey = picture.mean(axis=2, keepdims=True)
    picture = grey + (picture - grey) * float(rng.uniform(0.7, 1.5))
    low, high = rng.uniform(0, 0.06), rng.uniform(0.9, 1.04)
    return (low + (high - low) * picture).astype(np.float32)


def _glowing(radiance: np.ndarray, share: float, rng: np.random.Generator) -> np.ndarray:
    """Stray light in the lens around what is very bright."""
    level = np.percentile(radiance, 97)
    bright = np.clip(radiance - level, 0, 4 * level)
    return radiance + share * cv2.GaussianBlur(bright, (0, 0), float(rng.uniform(2, 12)))
