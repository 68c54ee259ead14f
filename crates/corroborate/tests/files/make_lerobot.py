"""Writes datasets with LeRobot's own program (lerobot 0.4.4, format 3.0) into a folder: python make_lerobot.py FOLDER

`set` has five episodes of two tasks with the features that `lerobot-eval` records, but images; its data stand in two files. The
first, the third and the fourth episode succeed, the fourth in its midst. `demonstrations` does not say what succeeded.
"""

import os
import sys
from pathlib import Path

import numpy as np

os.environ["HF_HUB_OFFLINE"] = "1"
from lerobot.datasets.lerobot_dataset import LeRobotDataset  # noqa: E402

STATE = {
    "observation.state": {"dtype": "float32", "shape": (2,), "names": None},
    "action": {"dtype": "float32", "shape": (2,), "names": None},
}
OUTCOME = {
    "next.reward": {"dtype": "float32", "shape": (1,), "names": None},
    "next.success": {"dtype": "bool", "shape": (1,), "names": None},
    "next.done": {"dtype": "bool", "shape": (1,), "names": None},
}
# Of each episode its task, its frames, and the frame at which it succeeds.
EPISODES = [("pick", 6, 5), ("pick", 4, None), ("place", 5, 4), ("place", 7, 3), ("place", 3, None)]


def write(folder: Path, features: dict, parts: list) -> None:
    dataset = LeRobotDataset.create(repo_id="example/set", fps=10, features=features, root=folder, use_videos=False)
    for part in parts:
        if part is not parts[0]:
            # Recording that is resumed begins new files.
            dataset.finalize()
            dataset = LeRobotDataset("example/set", root=folder)
        for task, frames, success in part:
            for at in range(frames):
                frame = {name: np.full(2, at / 10, np.float32) for name in STATE}
                values = {
                    "next.reward": np.array([float(at == success)], np.float32),
                    "next.success": np.array([at == success]),
                    "next.done": np.array([at + 1 == frames]),
                }
                frame |= {name: values[name] for name in features if name in values}
                dataset.add_frame(frame | {"task": task})
            dataset.save_episode()
    dataset.finalize()


folder = Path(sys.argv[1])
write(folder / "set", STATE | OUTCOME, [EPISODES[:3], EPISODES[3:]])
write(folder / "demonstrations", STATE, [EPISODES[:2]])
