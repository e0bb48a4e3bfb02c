"""Send a clip as a stream of poses to a local port: python send_clip.py CLIP.bvh"""

import argparse
import json
import socket
import time

import twistcore as tc


def send(motion, port, *, seconds):
    """Send every frame of a motion, with a pause of `seconds` after each."""
    with socket.create_connection(("127.0.0.1", port)) as stream:
        for rotations, position in zip(motion.rotations, motion.positions[:, 0], strict=True):
            pose = {"rotations": rotations.tolist(), "position": position.tolist()}
            stream.sendall(json.dumps(pose).encode() + b"\n")
            time.sleep(seconds)


def main():
    """Send the clip at its own frame rate."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("clip")
    parser.add_argument("--port", type=int, default=9763)
    given = parser.parse_args()
    motion = tc.read_clip(given.clip).motion
    send(motion, given.port, seconds=motion.frame_time)


if __name__ == "__main__":
    main()
