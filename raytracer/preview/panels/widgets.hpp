#pragma once

#include <optional>
#include <string>

/// What several panels are made of.
namespace terravox::panels::widgets {

/// Shown when the mouse rests on the item before.
void tip(const std::string& text);

struct Typed {
    std::string text;
    bool entered = false;  ///< by Enter; else the field was left
};
/// A line of text to type into; what is typed counts when it is entered, or left.
/// @return what it says now, once somebody has changed or entered it
[[nodiscard]] std::optional<widgets::Typed> text_input(const char* label, const std::string& now,
                                                       std::size_t most = 400,
                                                       const char* hint = "");

/// Goes back to what was; grey where there is nothing to go back to.
[[nodiscard]] bool reset_button(bool enabled);

/// For tests that drive the window: says in the log, at level trace, where the item before lies,
/// when it has moved.
void report_place(const std::string& name);
/// ImGui::Button, whose place is reported.
[[nodiscard]] bool button(const char* label, bool enabled = true);

}  // namespace terravox::panels::widgets
