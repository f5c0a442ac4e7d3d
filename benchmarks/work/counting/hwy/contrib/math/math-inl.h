#pragma once
// Stands for Highway's: its functions are in counting/hwy/highway.h.
