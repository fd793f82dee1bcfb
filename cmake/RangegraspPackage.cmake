# Debian packages: `cpack --config build/release/CPackConfig.cmake` makes rangegrasp_*.deb (the program and everything it needs
# to run) and librangegrasp-dev_*.deb (the modules, for building other programs) in the current folder.
set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGE_NAME rangegrasp)
set(CPACK_PACKAGE_VENDOR "the rangegrasp authors")
set(CPACK_PACKAGE_CONTACT "the rangegrasp authors <authors@rangegrasp.invalid>")
set(CPACK_PACKAGE_DESCRIPTION_SUMMARY "${PROJECT_DESCRIPTION}")
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_STRIP_FILES ON)
set(CPACK_INSTALL_DEFAULT_DIRECTORY_PERMISSIONS
  OWNER_READ OWNER_WRITE OWNER_EXECUTE GROUP_READ GROUP_EXECUTE WORLD_READ WORLD_EXECUTE)
set(CPACK_COMPONENTS_ALL Runtime Development)
set(CPACK_COMPONENTS_GROUPING IGNORE)

set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_PRIORITY optional)

set(CPACK_DEBIAN_RUNTIME_PACKAGE_NAME rangegrasp)
set(CPACK_DEBIAN_RUNTIME_PACKAGE_SECTION science)
set(CPACK_DEBIAN_RUNTIME_PACKAGE_SHLIBDEPS ON)
# Needed by the sandbox of external detectors, for videos and pictures, and by the pages of `report`.
set(CPACK_DEBIAN_RUNTIME_PACKAGE_RECOMMENDS "bubblewrap, ffmpeg, libjs-chart.js, libjs-three, libosmesa6")
# libmujoco is part of this package; dpkg-shlibdeps must find it here, because no other package provides it.
get_filename_component(CPACK_DEBIAN_PACKAGE_SHLIBDEPS_PRIVATE_DIRS "${MUJOCO_LIBRARY}" DIRECTORY)
list(APPEND CPACK_DEBIAN_PACKAGE_SHLIBDEPS_PRIVATE_DIRS "${PROJECT_SOURCE_DIR}/.cache/coacd.libs")
set(CPACK_COMPONENT_RUNTIME_DESCRIPTION
"A simulated arm with a hand and a range sensor picks unknown objects from a
table: scan, segmentation, completion, grasps, motion, physics. The program
runs whole experiments and prints their tables beside the published ones.")

set(CPACK_DEBIAN_DEVELOPMENT_PACKAGE_NAME librangegrasp-dev)
set(CPACK_DEBIAN_DEVELOPMENT_PACKAGE_SECTION libdevel)
set(CPACK_COMPONENT_DEVELOPMENT_DESCRIPTION
"The modules of rangegrasp as static libraries, with their headers and the
files by which CMake finds them: find_package(rangegrasp).")
# The dependencies of rangegraspConfig.cmake; libmujoco is in the other package.
set(development_packages libassimp-dev libcgal-dev libeigen3-dev libembree-dev libfcl-dev libfmt-dev libompl-dev
  libopencv-calib3d-dev libopencv-core-dev libopencv-imgproc-dev libpcl-dev libpng-dev libpugixml-dev libspdlog-dev libsqlite3-dev libtbb-dev libtiff-dev libyaml-cpp-dev pkg-config)
list(JOIN development_packages ", " development_packages)
set(CPACK_DEBIAN_DEVELOPMENT_PACKAGE_DEPENDS "rangegrasp (= ${PROJECT_VERSION}), ${development_packages}")

include(CPack)
