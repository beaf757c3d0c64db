# cmake -DSIZE=arm-none-eabi-size -DIMAGE=x.elf -DTEXT=8192 -DRAM=2048 -P footprint.cmake
# Fails when the image has more octets of flash (text, data) or of RAM (data, bss, stack) than that.
execute_process(COMMAND ${SIZE} ${IMAGE} OUTPUT_VARIABLE report COMMAND_ERROR_IS_FATAL ANY)
string(REGEX MATCH "\n *([0-9]+)[ \t]+([0-9]+)[ \t]+([0-9]+)" line "${report}")
set(text ${CMAKE_MATCH_1})
set(data ${CMAKE_MATCH_2})
set(bss ${CMAKE_MATCH_3})
math(EXPR flash "${text} + ${data}")
math(EXPR ram "${data} + ${bss} - ${STACK}")
message(STATUS "${IMAGE}: ${flash} octets of flash (at most ${TEXT}), ${ram} of RAM (at most ${RAM})")
if(flash GREATER TEXT OR ram GREATER RAM)
    message(FATAL_ERROR "over its bound")
endif()
