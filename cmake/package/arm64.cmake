# Read by CPack when the packages are for the robot and not for this machine.
set(SHLIBDEPS_EXECUTABLE ${CMAKE_CURRENT_LIST_DIR}/arm64-shlibdeps)
