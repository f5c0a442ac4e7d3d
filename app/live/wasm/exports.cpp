// What the page may call. One scene to an instance; see app/live/messages.hpp for the messages.
#include <cstdlib>
#include <exception>
#include <memory>
#include <span>
#include <string>
#include <typeinfo>
#include <vector>

#include "app/live/messages.hpp"

namespace {

namespace live = livermark::live;

std::vector<double> message;
std::string answer;
std::unique_ptr<live::Scene> scene;

} // namespace

extern "C" {

/// Given by the page: keeps a sentence, and does not return.
[[noreturn]] __attribute__((import_module("livermark"), import_name("fault"))) void
livermark_fault(const char *sentence, std::size_t length);

/// Room for a message of that many float64.
[[clang::export_name("room")]] double *room(std::size_t num_numbers) {
    message.assign(num_numbers, 0.0);
    return message.data();
}

/// Begin of the last answer.
[[clang::export_name("answer")]] const char *answer_begin() {
    return answer.data();
}

/// Makes a scene of the message.
[[clang::export_name("open")]] void open() {
    scene.reset();
    scene = live::scene_of(message);
}

/// Answers the message. @return number of bytes
[[clang::export_name("reply")]] std::size_t reply() {
    answer = live::reply(*scene, message);
    return answer.size();
}

/// Names of the springs. @return number of bytes
[[clang::export_name("spring_laws")]] std::size_t spring_laws() {
    answer = live::joined_spring_names();
    return answer.size();
}

// The C++ library of WebAssembly is made without exceptions. Ours carry a sentence to the reader of the page, and
// nobody catches them on the way: the page gets the sentence, and what was going on ends there.
void *__cxa_allocate_exception(std::size_t size) noexcept {
    return std::malloc(size);
}
void __cxa_free_exception(void *exception) noexcept {
    std::free(exception);
}
/// All that is thrown here comes from std::exception alone, which then is at its beginning.
[[noreturn]] void __cxa_throw(void *exception, std::type_info * /*type*/, void * /*destructor*/) {
    const std::string sentence = static_cast<const std::exception *>(exception)->what();
    livermark_fault(sentence.data(), sentence.size());
}
}
