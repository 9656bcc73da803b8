# The example of a module of one's own builds and runs against an installed ilss that was moved
# after installing: cmake -D SOURCE_DIR=... -D BUILD_DIR=... -D WORK_DIR=... -P this file.
function(run result)
  execute_process(COMMAND ${ARGN} RESULT_VARIABLE status OUTPUT_VARIABLE output
                  ERROR_VARIABLE error)
  if(NOT status STREQUAL 0)
    list(JOIN ARGN " " command)
    message(FATAL_ERROR "${command}\nended with ${status}:\n${output}${error}")
  endif()
  set(${result} "${output}" PARENT_SCOPE)
endfunction()

function(expect_between what low value high)
  if(NOT (low LESS value AND value LESS high))
    message(FATAL_ERROR "${what} is ${value}, expected between ${low} and ${high}")
  endif()
endfunction()

file(REMOVE_RECURSE ${WORK_DIR})
run(_ ${CMAKE_COMMAND} --install ${BUILD_DIR} --prefix ${WORK_DIR}/staged)
file(RENAME ${WORK_DIR}/staged ${WORK_DIR}/prefix)

run(_ ${CMAKE_COMMAND} -G Ninja -S ${SOURCE_DIR}/docs/examples/sound_speed -B ${WORK_DIR}/build
      -D CMAKE_BUILD_TYPE=Release -D CMAKE_PREFIX_PATH=${WORK_DIR}/prefix
      "-D CMAKE_CXX_FLAGS=-Wall -Wextra -Wconversion -Wshadow -Werror")
run(_ ${CMAKE_COMMAND} --build ${WORK_DIR}/build)

set(ilss ${WORK_DIR}/prefix/bin/ilss --plugin ${WORK_DIR}/build/libsound_speed.so)
run(listing ${ilss} modules sound_speed_correction)
foreach(expected "air_temperature" "assumed_temperature" "sonar_reading" "out_of_range")
  if(NOT listing MATCHES ${expected})
    message(FATAL_ERROR "`ilss modules` does not show ${expected}:\n${listing}")
  endif()
endforeach()

# At T = -10 +- 2 degrees and T0 = 20: r = sqrt(263.15 / 293.15) 1 m = 0.94745 m, and its variance is
# (0.94745 2 mm)² + (r / (2 T) 2 K)² = 3.591e-6 + 12.963e-6 = 16.554e-6 m².
run(json ${ilss} eval sound_speed_correction --json
         --param "air_temperature={value: 263.15 K, std: 2 K}"
         --input "reading={range: {value: 1 m, std: 2 mm}}")
string(JSON name GET "${json}" output components 0 name)
if(NOT name STREQUAL "range")
  message(FATAL_ERROR "the first component is '${name}', expected 'range':\n${json}")
endif()
string(JSON range GET "${json}" output components 0 value)
string(JSON variance GET "${json}" output covariance 0 0)
expect_between("the range" 0.947450 ${range} 0.947452)
expect_between("its variance" 1.6553e-5 ${variance} 1.6554e-5)
