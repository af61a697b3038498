"""The same small recording as every program writes it: three points, three frames, one of the points without a name."""

import numpy as np

VICON = """Trajectories
100
,,Nick:LASI,,,Nick:RASI,,,*12,,
Frame,Sub Frame,X,Y,Z,X,Y,Z,X,Y,Z
,,mm,mm,mm,mm,mm,mm,mm,mm,mm
240,0,1.50,2,3,4,5,6,,,
241,0,7,8,9,,,,16,17,18
242,0,1,2,3,4,5,6,19,20,21.25
"""
VICON_WITH_OTHERS = f"""Devices
1000
,,Force,
Frame,Sub Frame,Fx
,,N
240,0,1.5

{VICON}
Model Outputs
100
,,Nick:LHipAngles,,
Frame,Sub Frame,X,Y,Z
,,deg,deg,deg
240,0,1,2,3
"""
MOTIVE = f"""Format Version,1.23,Take Name,"walk, slow",Capture Frame Rate,100.000000,Export Frame Rate,100.000000,\
Total Exported Frames,3,Rotation Type,Quaternion,Length Units,Meters,Coordinate Space,Global

,,Rigid Body,Rigid Body,Rigid Body,Marker,Marker,Marker,Marker,Marker,Marker,Marker,Marker,Marker
,,Wand,Wand,Wand{",Nick:LASI" * 3}{",Nick:RASI" * 3}{",Unlabeled 1189" * 3}
,,"A:1","A:1","A:1","B:1","B:1","B:1","C:1","C:1","C:1","D:1","D:1","D:1"
,,Position,Position,Position,Position,Position,Position,Position,Position,Position,Position,Position,Position
Frame,Time (Seconds),X,Y,Z,X,Y,Z,X,Y,Z,X,Y,Z
240,2.400000,9,9,9,0.0015,0.002,0.003,0.004,0.005,0.006,,,
241,2.410000,9,9,9,0.007,0.008,0.009,,,,0.016,0.017,0.018
242,2.420000,9,9,9,0.001,0.002,0.003,0.004,0.005,0.006,0.019,0.020,0.02125
"""
QTM = """NO_OF_FRAMES\t3
NO_OF_CAMERAS\t12
NO_OF_MARKERS\t3
FREQUENCY\t100
NO_OF_ANALOG\t0
ANALOG_FREQUENCY\t0
DESCRIPTION\t--
TIME_STAMP\t2022-06-03, 10:47:36.627\t94247.45402301
DATA_INCLUDED\t3D
MARKER_NAMES\tLASI\tRASI\t
TRAJECTORY_TYPES\tMeasured\tMeasured\tMixed
Frame\tTime\tLASI X\tLASI Y\tLASI Z\tRASI X\tRASI Y\tRASI Z\t X\t Y\t Z
240\t2.39000\t1.50\t2\t3\t4\t5\t6\t\t\t
241\t2.40000\t7\t8\t9\t0.000\t0.000\t0.000\t16\t17\t18
242\t2.41000\t1\t2\t3\t4\t5\t6\t19\t20\t21.25
"""
TRC = """PathFileType\t4\t(X/Y/Z)\twalk.trc
DataRate\tCameraRate\tNumFrames\tNumMarkers\tUnits\tOrigDataRate\tOrigDataStartFrame\tOrigNumFrames
100.00\t100.00\t3\t3\tmm\t100.00\t240\t3
Frame#\tTime\tLASI\t\t\tRASI\t\t\tU_12\t\t
\t\tX1\tY1\tZ1\tX2\tY2\tZ2\tX3\tY3\tZ3

240\t2.390\t1.50\t2\t3\t4\t5\t6\t\t\t
241\t2.400\t7\t8\t9\t\t\t\t16\t17\t18
242\t2.410\t1\t2\t3\t4\t5\t6\t19\t20\t21.25
"""
FILES = {
    "vicon.csv": VICON,
    "others.csv": VICON_WITH_OTHERS,
    "motive.csv": MOTIVE,
    "qtm.tsv": QTM,
    "motion-analysis.trc": TRC,
}
POINTS = np.array(
    [
        [[1.5, 2, 3], [4, 5, 6], [np.nan] * 3],
        [[7, 8, 9], [np.nan] * 3, [16, 17, 18]],
        [[1, 2, 3], [4, 5, 6], [19, 20, 21.25]],
    ]
)
"""In millimetres."""
