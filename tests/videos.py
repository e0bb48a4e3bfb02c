"""Small videos whose pictures carry their number, for tests of the witness video."""

from fractions import Fraction

import av
import numpy as np

WIDTH, HEIGHT, BITS = 160, 96, 10


def write_video(path, frames, rate, codec="mpeg4", times=None, size=(WIDTH, HEIGHT), degrees=0):
    """A video with key frames 12 apart and, where the codec has them, frames stored out of order.

    rate: frames per second; times: milliseconds at which the frames begin, if not by the rate.
    """
    with av.open(str(path), "w") as container:
        stream = container.add_stream(codec, rate=Fraction(rate))
        stream.width, stream.height = size
        stream.pix_fmt = "yuvj420p" if codec == "mjpeg" else "yuv420p"
        stream.bit_rate = 2_000_000
        if times is not None:
            stream.codec_context.time_base = Fraction(1, 1000)
        if codec != "mjpeg":
            stream.codec_context.gop_size = 12
            stream.codec_context.max_b_frames = 2
        if degrees:
            stream.set_display_rotation(degrees)
        for k in range(frames):
            frame = av.VideoFrame.from_ndarray(numbered(k, size), format="rgb24")
            if times is None:
                frame.pts, frame.time_base = k, 1 / Fraction(rate)
            else:
                frame.pts, frame.time_base = times[k], Fraction(1, 1000)
            container.mux(stream.encode(frame))
        container.mux(stream.encode(None))
    return path


def numbered(number, size=(WIDTH, HEIGHT)):
    """A picture of the number's bits, the highest left: white for 1, black for 0."""
    width, height = size
    bits = [number >> k & 1 for k in reversed(range(BITS))]
    row = np.repeat(np.array(bits, dtype=np.uint8) * 255, width // BITS)
    row = np.pad(row, (0, width - len(row)))
    return np.repeat(np.tile(row, (height, 1))[:, :, None], 3, axis=2)


def number_in(pixels):
    """The number that a picture shows, at whatever size."""
    middle = pixels[pixels.shape[0] // 2, :, 1].astype(float)
    at = (np.arange(BITS) + 0.5) * len(middle) / BITS
    bits = middle[at.astype(int)] > 127
    return int(sum(int(bit) << k for k, bit in enumerate(reversed(bits))))
