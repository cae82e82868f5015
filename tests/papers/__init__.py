from vcmm.face.twins import open_folder

open_folder()  # the tests import what lies beside the scenarios
