#pragma once

#include <optional>
#include <string>

/// Widgets that several panels use.
namespace terravox::panels::widgets {

/// Adds a tooltip to the last item.
void tip(const std::string& text);

struct Typed {
    std::string text;
    bool entered = false;  ///< whether it was confirmed by Enter; else the field lost the focus
};
/// A text field; its text takes effect on Enter or when it loses the focus.
/// @return the text when it has been changed or entered
[[nodiscard]] std::optional<widgets::Typed> text_input(const char* label, const std::string& now,
                                                       std::size_t max_bytes = 400,
                                                       const char* hint = "");

/// A button that resets a value; grey if there is nothing to reset.
[[nodiscard]] bool reset_button(bool enabled);

/// For tests that drive the window: logs the position of the last item at level trace when it has
/// moved.
void report_place(const std::string& name);
/// ImGui::Button whose position is reported (report_place).
[[nodiscard]] bool button(const char* label, bool enabled = true);

}  // namespace terravox::panels::widgets
