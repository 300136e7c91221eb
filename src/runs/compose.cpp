#include "recon/runs/compose.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <utility>

#include "recon/core/names.hpp"

namespace recon::mpm {
namespace {

// The number that a text is. Throws by refuse() for a text that is none.
template <class Refuse>
double number_of(std::string_view text, const Refuse& refuse) {
  double number = 0;
  const auto end = std::from_chars(text.data(), text.data() + text.size(), number);
  if (end.ec != std::errc() || end.ptr != text.data() + text.size() || !std::isfinite(number))
    refuse("must be a number");
  return number;
}

// The place of a word among others.
template <class Refuse>
std::size_t place_of(std::string_view word, const std::vector<std::string>& words,
                     const Refuse& refuse) {
  const auto found = std::find(words.begin(), words.end(), word);
  if (found == words.end()) refuse("is unknown; " + suggest(word, words));
  return static_cast<std::size_t>(found - words.begin());
}

template <class T, class Refuse>
void read(std::string_view text, T& choice, const Refuse& refuse) {
  if constexpr (std::is_enum_v<T>) {
    choice = static_cast<T>(place_of(text, names_of<T>(), refuse));
  } else if constexpr (std::is_same_v<T, bool>) {
    choice = place_of(text, {"false", "true"}, refuse) == 1;
  } else {
    const double number = number_of(text, refuse);
    if (std::is_integral_v<T> && !(std::abs(number) < 1e6 && number == std::floor(number)))
      refuse("must be a whole number");
    choice = static_cast<T>(number);
  }
}

template <class T>
std::string text_of(T choice) {
  if constexpr (std::is_enum_v<T>) {
    return std::string(name_of(choice));
  } else if constexpr (std::is_same_v<T, bool>) {
    return choice ? "true" : "false";
  } else {
    char text[32];
    return {text, std::to_chars(text, text + sizeof text, choice).ptr};
  }
}

// Calls work(choice) with the choice of this key.
template <class M, class Work>
void with_choice(M& method, std::string_view key, const Work& work) {
  bool found = false;
  method.choices([&](std::string_view each, auto& choice) {
    if (each != key) return;
    found = true;
    work(choice);
  });
  if (!found)
    recon::detail::throw_invalid("choice of a method", key,
                                 "is unknown; " + suggest(key, method_keys()));
}

}  // namespace

std::vector<std::string> method_keys() {
  std::vector<std::string> keys;
  Method().choices([&](const char* key, const auto&) { keys.emplace_back(key); });
  return keys;
}

std::vector<std::string> words_of(std::string_view key) {
  std::vector<std::string> words;
  const Method any;
  with_choice(any, key, [&]<class T>(const T&) {
    if constexpr (std::is_enum_v<T>) words = names_of<T>();
  });
  return words;
}

void set_choice(Method& method, std::string_view key, std::string_view value) {
  with_choice(method, key, [&](auto& choice) {
    read(value, choice, [&](const std::string& rule) {
      recon::detail::throw_invalid(std::string(key) + " of the method", value, rule);
    });
  });
}

std::string choice_text(const Method& method, std::string_view key) {
  std::string text;
  with_choice(method, key, [&](const auto& choice) { text = text_of(choice); });
  return text;
}

namespace {

// A choice of a composition: "key=value", or a word of one key alone.
std::pair<std::string, std::string_view> choice_of(std::string_view part) {
  const std::size_t equals = part.find('=');
  if (equals != std::string_view::npos)
    return {std::string(part.substr(0, equals)), part.substr(equals + 1)};
  std::vector<std::string> known, of;
  for (const std::string& key : method_keys())
    for (const std::string& word : words_of(key)) {
      known.push_back(word);
      if (word == part) of.push_back(key);
    }
  if (of.size() != 1)
    recon::detail::throw_invalid(
        "choice of a method", part,
        of.empty() ? "is no word of a key; " + suggest(part, known)
                   : "is a word of several keys: say which, KEY=" + std::string(part));
  return {of.front(), part};
}

// Calls work(key, value) for each choice behind the row of a composition.
template <class Work>
void with_choices(std::string_view text, const Work& work) {
  for (std::size_t at = text.find('+'); at < text.size();) {
    const std::size_t stop = std::min(text.find('+', at + 1), text.size());
    const auto [key, value] = choice_of(text.substr(at + 1, stop - at - 1));
    work(key, value);
    at = stop;
  }
}

}  // namespace

std::vector<std::string> keys_of(std::string_view text) {
  std::vector<std::string> keys;
  with_choices(text, [&](const std::string& key, std::string_view) { keys.push_back(key); });
  return keys;
}

Method composed(std::string_view text) {
  Method method = method_named(text.substr(0, text.find('+')));
  std::vector<std::string> said;
  with_choices(text, [&](const std::string& key, std::string_view value) {
    if (std::find(said.begin(), said.end(), key) != said.end())
      recon::detail::throw_invalid(key + " of the method", value,
                                   "is said before in '" + std::string(text) + "': once is enough");
    said.push_back(key);
    set_choice(method, key, value);
  });
  method.name = text;
  return method;
}

}  // namespace recon::mpm
