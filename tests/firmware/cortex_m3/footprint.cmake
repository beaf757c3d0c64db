# cmake -DSIZE=arm-none-eabi-size -DIMAGE=x.elf -DTEXT=8192 -DRAM=2048 -DSTACK=0 -P footprint.cmake
# Fails when the image has more octets of flash (text, data) or of RAM (data, bss, stack) than that.
include(${CMAKE_CURRENT_LIST_DIR}/../../../firmware/cortex_m3/image_size.cmake)
image_size(${IMAGE} ${STACK} flash ram)
message(STATUS "${IMAGE}: ${flash} octets of flash (at most ${TEXT}), ${ram} of RAM (at most ${RAM})")
if(flash GREATER TEXT OR ram GREATER RAM)
    message(FATAL_ERROR "over its bound")
endif()
