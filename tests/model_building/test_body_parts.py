"""What marker names say, over the families of names in common use."""

import pytest

from dshpm_jax._model_building.body_parts import meet, parts_of, parts_of_each


@pytest.mark.parametrize(
    ("names", "parts"),
    [
        ("LFHD RBHD Head_FL ARIEL", "head"),
        ("C7 T10 CLAV STRN RBAK L_Sternum Spine MAN", "trunk"),
        ("LASI RPSI SACR L.ASIS r.PSIS LFWT Hip_BR", "pelvis"),
        ("LKNE Knee_L L_knee LLEPI LPAT L_mknee", "left thigh+left shank"),
        ("RELB Elbow_R R_elbow_lat RLEL RMEL RIEL", "right forearm+right upper arm"),
        ("LANK Ankle_L L_ankle LLMAL", "left foot+left shank"),
        ("RTHI RTH2 r_thigh5 RTHAP", "right thigh"),
        ("LTIB LTB1 L_sh2 L_shank_antsup LTIAD LSHN", "left shank"),
        ("RTOE RHEE r_5meta RMT5 BigToe_R RCAL RP1MT RMFS", "right foot"),
        ("LSHO Shoulder_L L_Shoulder LACR LSH LFSH", "left upper arm+trunk"),
        ("RWRA Radius_R R_wrist_ulna ROWR RWR", "right forearm+right hand"),
        ("LFIN Finger_L LIHAND LTHM LThumb Thumb_L LINDEX L_Index LPinkie L_Pinky Pinkie_L LHM5", "left hand"),
        ("LToeTip LTOE5 LBigToe Hallux_L LPinkieToe L_PinkyToe LittleToe_L LSmallToe LMT5", "left foot"),
        ("LUPA LUA1 L_humerus LARM", "left upper arm"),
        ("P1 q7 x52", ""),
    ],
)
def test_parts_of_common_names(names, parts):
    for name in names.split():
        assert parts_of(name) == frozenset(filter(None, parts.split("+"))), name


def test_a_pinkie_beside_a_big_toe_is_a_toe():
    """As in the 28 markers of the MoCap Toolbox, which have one finger a hand and two toes a foot."""
    feet = ["BigToe_L", "Pinkie_L", "Finger_L", "RPinky"]
    assert parts_of_each(feet) == [{"left foot"}, {"left foot"}, {"left hand"}, {"right foot"}]
    fingers = ["BigToe_L", "Pinkie_L", "Thumb_L"]
    assert parts_of_each(fingers) == [{"left foot"}, {"left hand"}, {"left hand"}]
    assert parts_of_each(["LTOE", "LPinkie"]) == [{"left foot"}, {"left hand"}]


def test_parts_meet_on_their_own_side_only():
    assert meet("left thigh", "left shank") and meet("trunk", "right upper arm")
    assert not meet("left thigh", "right shank") and not meet("head", "pelvis")
