// Foreign text in messages.
#pragma once

#include <string>
#include <string_view>

namespace ilss {

/// What a file holds, for a message about it: what a terminal or JSON could not take shows as '?',
/// long text is cut.
std::string shown(std::string_view text);

}  // namespace ilss
