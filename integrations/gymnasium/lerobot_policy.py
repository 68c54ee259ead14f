"""A policy of LeRobot from a folder of its own, as `gymnasium_rig.py --policy lerobot:FOLDER` has it.

The folder is what `save_pretrained` writes: `config.json`, `model.safetensors`, and the processors that normalise what goes in and
out. A vector becomes `observation.state`, or `observation.environment_state` where the policy was trained with that; of a Dict, the key `agent_pos` becomes `observation.state`, `environment_state`
`observation.environment_state`, and each picture of `pixels` `observation.image` or `observation.images.NAME`, as numbers from 0 to 1
with the channels first.

Written for LeRobot 0.4.4 by its own evaluation; it needs PyTorch, some gigabytes, and is not tested in this repository.
"""

from __future__ import annotations

import random
from typing import Any, Dict, Sequence

import numpy
import torch
from lerobot.configs.policies import PreTrainedConfig
from lerobot.policies.factory import get_policy_class, make_pre_post_processors

NAMES = {"agent_pos": "observation.state", "environment_state": "observation.environment_state"}


def batch_of(observation: Any, inputs: Sequence[str]) -> Dict[str, torch.Tensor]:
    """An observation under the names of LeRobot, as a batch of one; `inputs` are those that the policy was trained with."""
    if not isinstance(observation, dict):
        # A vector alone: policies of LeRobot want it as the state of the environment, or as both.
        wanted = [name for name in NAMES.values() if name in inputs]
        return {name: _numbers(observation) for name in wanted or ["observation.state"]}
    batch = {}
    for key, value in observation.items():
        if key != "pixels":
            batch[NAMES.get(key, f"observation.{key}")] = _numbers(value)
        elif isinstance(value, dict):
            batch.update({f"observation.images.{name}": _picture(one) for name, one in value.items()})
        else:
            batch["observation.image"] = _picture(value)
    return batch


def _numbers(value: Any) -> torch.Tensor:
    return torch.from_numpy(numpy.ravel(numpy.asarray(value, dtype=numpy.float32))).unsqueeze(0)


def _picture(value: Any) -> torch.Tensor:
    return torch.from_numpy(numpy.ascontiguousarray(value)).permute(2, 0, 1).unsqueeze(0).float() / 255


class LeRobotPolicy:
    """The policy on the processor, one thread, without gradients: the same observations give the same actions."""

    def __init__(self, folder: str):
        torch.set_num_threads(1)
        config = PreTrainedConfig.from_pretrained(folder)
        config.device = "cpu"
        self.policy = get_policy_class(config.type).from_pretrained(folder, config=config).eval()
        self.inputs = list(config.input_features)
        device = {"device_processor": {"device": "cpu"}}
        self.before, self.after = make_pre_post_processors(config, folder, preprocessor_overrides=device)

    def reset(self, seed: int) -> None:
        """Forgets the last episode; what the policy draws has the seed."""
        random.seed(seed)
        numpy.random.seed(seed)
        torch.manual_seed(seed)
        self.policy.reset()

    def select_action(self, observation: Any) -> numpy.ndarray:
        """The action for what is seen."""
        with torch.inference_mode():
            action = self.after(self.policy.select_action(self.before(batch_of(observation, self.inputs))))
        return action.squeeze(0).cpu().numpy()
